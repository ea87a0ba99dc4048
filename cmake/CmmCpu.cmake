# The instructions that the code may use: `host` takes the wider vectors of x86-64-v3 (AVX2 and FMA, processors from 2013
# on) where the machine that builds has them, `baseline` runs on every x86-64. Whoever uses a layer is compiled for the
# same; how Eigen aligns its types does not depend on it.
include(CheckCXXSourceRuns)
set(CMMLIVE_CPU "host" CACHE STRING "Processors that the program runs on: like the one that builds (host), or all (baseline)")
set_property(CACHE CMMLIVE_CPU PROPERTY STRINGS host baseline)
set(cmm_cpu_options "")
if(CMMLIVE_CPU STREQUAL "host" AND CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
    set(CMAKE_REQUIRED_FLAGS "-march=x86-64-v3")
    check_cxx_source_runs("int main() { return __builtin_cpu_supports(\"avx2\") && __builtin_cpu_supports(\"fma\") &&
        __builtin_cpu_supports(\"bmi2\") ? 0 : 1; }" CMMLIVE_HOST_IS_V3)
    unset(CMAKE_REQUIRED_FLAGS)
    if(CMMLIVE_HOST_IS_V3)
        set(cmm_cpu_options -march=x86-64-v3)
    endif()
endif()

function(cmm_for_cpu target)
    target_compile_options(${target} PUBLIC ${cmm_cpu_options})
    target_compile_definitions(${target} PUBLIC EIGEN_MAX_ALIGN_BYTES=16)
endfunction()
