// The Koyna dam with a stepped crack at its neck. Make the mesh with: gmsh -2 koyna.geo
size = 9.0;                            // m, of triangles; the dam divides each into three cells

Point(1) = {0, 0, 0, size};            // heel: the origin
Point(2) = {70, 0, 0, size};           // toe
Point(3) = {19.25, 66.5, 0, size};
Point(4) = {14.8, 103, 0, size};
Point(5) = {0, 103, 0, size};
Point(6) = {0, 91.75, 0, size};        // the water level needs a point
Point(7) = {0, 64, 0, size};           // the crack: from the upstream side ...
Point(8) = {8, 64, 0, size};
Point(9) = {11, 66.5, 0, size};        // ... to the bend of the downstream side

Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 5};
Line(5) = {5, 6};
Line(6) = {6, 7};
Line(7) = {7, 1};
Line(8) = {7, 8};
Line(9) = {8, 9};
Line(10) = {9, 3};

// Both surfaces share the crack's lines, so that the mesh has the same nodes on either side.
Curve Loop(1) = {1, 2, -10, -9, -8, 7};
Plane Surface(1) = {1};
Curve Loop(2) = {8, 9, 10, 3, 4, 5, 6};
Plane Surface(2) = {2};

Physical Curve("base") = {1};
Physical Curve("downstream") = {2, 3};
Physical Curve("upstream") = {5, 6, 7};
Physical Curve("neck") = {8, 9, 10};   // the crack's name in the scene
Physical Surface("concrete") = {1, 2};

Mesh.MshFileVersion = 4.1;
