# What comes in: part files, points, nominals, plans.
set(ACQUISITION_INPUT_SOURCES
    characteristic_spec.cpp
    ball_path.cpp clearance.cpp contour_sampling.cpp crv_file.cpp datum_touches.cpp cubic_spline.cpp delimited_file.cpp file_pattern.cpp keyword_file.cpp loft.cpp
    nom_file.cpp nominal.cpp nominal_edges.cpp nominal_mesh.cpp nominal_nom.cpp nominal_parametric.cpp nominal_sections.cpp nominal_step.cpp part_file.cpp part_frame.cpp plan.cpp plan_check.cpp plan_file.cpp plan_times.cpp
    ply_file.cpp points_file.cpp profile_starts.cpp six_point_spec.cpp stl_file.cpp tol_characteristics.cpp tol_file.cpp triangle_mesh.cpp uncertainty_spec.cpp unknown_scan.cpp)
