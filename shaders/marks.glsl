// What is drawn over the picture and bends with it: scale, mask, grid lines, folds, outline. Encoded, premultiplied.
// What is seldom shown costs nothing otherwise: scale and grid lines are there where SCALE and GRID are defined.

#include "outline.glsl"

uniform sampler2D mask;          // 1 in features
uniform sampler2D growth;        // per quad: 1 where lengths are doubled, -1 where they are halved
uniform usampler2D folded;       // one texel a quad, not 0 where it is folded
uniform usampler2D owners;        // per node, which of these colours the mask has
uniform vec4 mask_colors[16];
uniform vec4 grid_color, outline_color, fold_color, shrunk_color, grown_color;
uniform float grid_step;         // cells between grid lines
uniform float grid_fade;         // strength of the lines halfway between them
uniform float line_px;           // width of a line
uniform float before_mask;       // 1 where the picture as it was shows the mask, too

vec4 over(vec4 below, vec4 paint, float share) {
    float a = paint.a * share;
    return vec4(paint.rgb * a, a) + (1.0 - a) * below;
}

// Share of the pixel under a line of `width` px whose centre is `pixels` away.
vec2 line_share(vec2 pixels, float width) {
    return clamp(0.5 * width + 0.5 - pixels, 0.0, 1.0);
}

// Lines every `step` cells; those closer than a few pixels would only grey the picture.
vec2 grid_lines(vec2 cell, vec2 pixels_per_cell, float step) {
    vec2 distance = step * abs(fract(cell / step + 0.5) - 0.5) * pixels_per_cell;
    return line_share(distance, line_px) * smoothstep(2.5, 6.0, step * pixels_per_cell);
}

float grid_share(vec2 cell, vec2 pixels_per_cell) {
    vec2 coarse = grid_lines(cell, pixels_per_cell, grid_step);
    vec2 fine = grid_fade * grid_lines(cell, pixels_per_cell, 0.5 * grid_step);
    vec2 both = max(coarse, fine);
    return max(both.x, both.y);
}

float outline_share(vec2 cell, vec2 pixels_per_cell) {
    vec2 beyond = max(max(-cell, cell - last_cell), 0.0) * pixels_per_cell;
    vec2 edge = min(abs(cell), abs(last_cell - cell)) * pixels_per_cell;
    vec2 share = line_share(edge, 1.5 * line_px) * step(beyond.yx, vec2(line_px));
    return max(share.x, share.y);
}

// The mask's colour at grid coordinates: that of the nearest node.
vec4 mask_color(vec2 cell) {
    ivec2 node = ivec2(clamp(cell + 0.5, vec2(0.0), vec2(textureSize(owners, 0) - 1)));
    return mask_colors[min(int(texelFetch(owners, node, 0).r), 15)];
}

// `cell`: grid coordinates and their change per pixel; a change of 0 is where the mesh does not come.
vec4 marks(vec4 cell) {
    if (cell.z <= 0.0) return vec4(0.0);
    vec2 pixels_per_cell = 1.0 / cell.zw;
    vec2 place = cell.xy / last_cell;
    float inside = coverage(cell.xy, cell.zw);

    vec4 colour = vec4(0.0);
#ifdef SCALE
    float grown = texture(growth, place).r;
    colour = over(colour, grown < 0.0 ? shrunk_color : grown_color, inside * min(abs(grown), 1.0));
#endif
    colour = over(colour, mask_color(cell.xy), inside * texture(mask, place).r);
#ifdef GRID
    colour = over(colour, grid_color, inside * grid_share(cell.xy, pixels_per_cell));
#endif
    ivec2 quad = ivec2(clamp(floor(cell.xy), vec2(0.0), last_cell - 1.0));
    colour = over(colour, fold_color, texelFetch(folded, quad, 0).r > 0u ? inside : 0.0);
    return over(colour, outline_color, outline_share(cell.xy, pixels_per_cell));
}

// The mask alone, on the picture as it was.
vec4 marks_before(vec4 cell) {
    if (cell.z <= 0.0 || before_mask == 0.0) return vec4(0.0);
    return over(vec4(0.0), mask_color(cell.xy), coverage(cell.xy, cell.zw) * texture(mask, cell.xy / last_cell).r);
}
