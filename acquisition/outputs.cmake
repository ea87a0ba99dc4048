set(ACQUISITION_OUTPUT_SOURCES journal.cpp run_file.cpp sample_codec.cpp)
