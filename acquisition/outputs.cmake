# What is kept, judged and goes out: journal, evaluation, files, report.
set(ACQUISITION_OUTPUT_SOURCES
    evaluation.cpp events.cpp journal.cpp run_file.cpp sample_codec.cpp section_result.cpp)
