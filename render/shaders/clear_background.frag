// Clears all attachments of a sample.
layout(location = 0) out vec4 solid;
layout(location = 1) out vec4 normal;
layout(location = 2) out vec4 crust;

void main() { solid = normal = crust = vec4(0.0); }
