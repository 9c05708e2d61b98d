// Buffers of the solids that a sample sees (face.frag).
uniform sampler2D face_colour;     // rgb: albedo; a: roughness, minus 2 for metal
uniform sampler2D face_normals;    // octahedral_encode() of the normal with relief (xy) and without (zw)
uniform sampler2D face_distance;   // from the eye [m]; 0: none
