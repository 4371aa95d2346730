#version 330
// A surface in space, turned before the camera (app/render/surface_view.py).

uniform mat4 to_clip;    // space -> clip coordinates
uniform mat3 to_camera;  // normals of space -> normals before the camera, which looks along -z

in vec3 place;
in vec3 normal;
in vec2 share;  // of the texture's width and height, from its top left corner

out vec3 facing;
out vec2 at;

void main() {
    gl_Position = to_clip * vec4(place, 1.0);
    facing = to_camera * normal;
    at = share;
}
