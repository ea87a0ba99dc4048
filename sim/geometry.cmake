set(SIM_GEOMETRY_SOURCES bvh.cpp contact.cpp geometry_source.cpp loft.cpp mesh.cpp mesh_file.cpp mesh_ply.cpp mesh_stl.cpp
    parametric.cpp part.cpp patch.cpp probe.cpp profiles.cpp section_cut.cpp section_file.cpp spline.cpp tessellate.cpp)
