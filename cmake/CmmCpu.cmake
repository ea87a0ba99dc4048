# The instructions that the code may use: `host` takes the wider vectors of x86-64-v3 (AVX2 and FMA, processors from 2013
# on) where the machine that builds has them, `baseline` runs on every x86-64. Whoever uses a layer is compiled for the
# same.
include(CheckCXXSourceRuns)
set(CMMLIVE_CPU "host" CACHE STRING "Processors that the program runs on: like the one that builds (host), or all (baseline)")
set_property(CACHE CMMLIVE_CPU PROPERTY STRINGS host baseline)
set(cmm_is_v3 OFF)
if(CMMLIVE_CPU STREQUAL "host" AND CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
    set(CMAKE_REQUIRED_FLAGS "-march=x86-64-v3")
    check_cxx_source_runs("int main() { return __builtin_cpu_supports(\"avx2\") && __builtin_cpu_supports(\"fma\") &&
        __builtin_cpu_supports(\"bmi2\") ? 0 : 1; }" CMMLIVE_HOST_IS_V3)
    unset(CMAKE_REQUIRED_FLAGS)
    set(cmm_is_v3 ${CMMLIVE_HOST_IS_V3})
endif()

# With wider vectors Eigen would align its types, and pad what it allocates, in another way: it keeps to the 16 bytes that
# malloc aligns to, so that layouts do not depend on the processor and instrumented code frees what plain code allocated.
function(cmm_for_cpu target)
    if(cmm_is_v3)
        target_compile_options(${target} PUBLIC -march=x86-64-v3)
        target_compile_definitions(${target} PUBLIC EIGEN_MAX_ALIGN_BYTES=16 EIGEN_MALLOC_ALREADY_ALIGNED=1)
        # GCC 12 takes the vector loop of Eigen, into which short vectors never get, for a step out of them.
        target_compile_options(${target} PUBLIC $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds>)
    endif()
endfunction()
