layout(std430, binding = 1) buffer Corrections { vec2 x[]; };   // what a level's smoother works on
layout(std430, binding = 2) buffer Residuals { vec2 b[]; };     // its right-hand side
layout(std430, binding = 3) buffer Between { vec2 between[]; };
