// The solids that a sample sees, pixel by pixel (face.frag).
uniform sampler2D face_colour;     // albedo; roughness, less 2 where it is metal
uniform sampler2D face_normals;    // with its relief and without, octahedral_encode()
uniform sampler2D face_distance;   // from the eye [m]; 0: none
