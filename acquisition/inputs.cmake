# What comes in: part files, points, nominals, plans.
set(ACQUISITION_INPUT_SOURCES
    crv_file.cpp delimited_file.cpp file_pattern.cpp part_file.cpp points_file.cpp)
