// A flat tensile specimen with a hole in its middle, in mm. The meshes beside this file are made anew by
//   gmsh specimen.geo -2 -o specimen.msh && gmsh specimen.geo -2 -o specimen.inp

SetFactory("OpenCASCADE");
end = 60; // half the length of the specimen
grip = 38; // from the middle to where the grips hold it
gauge = 24; // half the length of the narrow part
wide = 10; narrow = 6; hole = 2; // half the widths, radius of the hole
shoulder = 14.5; // radius of the shoulders, which reach the full width 10 mm beyond the narrow part

// A plate, less what is above and below the narrow part, less the hole.
Rectangle(1) = {-end, -wide, 0, 2 * end, 2 * wide};
Rectangle(2) = {-gauge, narrow, 0, 2 * gauge, wide};
Rectangle(3) = {-gauge, -narrow - wide, 0, 2 * gauge, wide};
Disk(4) = {-gauge, narrow + shoulder, 0, shoulder};
Disk(5) = {gauge, narrow + shoulder, 0, shoulder};
Disk(6) = {-gauge, -narrow - shoulder, 0, shoulder};
Disk(7) = {gauge, -narrow - shoulder, 0, shoulder};
Disk(8) = {0, 0, 0, hole};
body() = BooleanDifference{ Surface{1}; Delete; }{ Surface{2:8}; Delete; };

// The parts in the grips, which share their inner edge with the rest.
Rectangle(11) = {-end, -wide, 0, end - grip, 2 * wide};
Rectangle(12) = {grip, -wide, 0, end - grip, 2 * wide};
all() = BooleanFragments{ Surface{body()}; Delete; }{ Surface{11, 12}; Delete; };
left() = Surface In BoundingBox{-end - 1, -wide - 1, -1, -grip + 1, wide + 1, 1};
right() = Surface In BoundingBox{grip - 1, -wide - 1, -1, end + 1, wide + 1, 1};
Physical Surface("specimen") = {all()};
Physical Surface("left_grip") = {left()};
Physical Surface("right_grip") = {right()};

// Sides of elements: 0.6 mm about the hole, growing to 1 mm 30 mm from it.
Field[1] = MathEval;
Field[1].F = "0.6 + 0.4 * Min(Sqrt(x * x + y * y) / 30, 1)";
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.Algorithm = 6;
Mesh.SaveAll = 0;
