set(SIM_GEOMETRY_SOURCES bvh.cpp contact.cpp geometry_source.cpp mesh.cpp mesh_file.cpp mesh_ply.cpp mesh_stl.cpp
    parametric.cpp part.cpp patch.cpp probe.cpp tessellate.cpp)
