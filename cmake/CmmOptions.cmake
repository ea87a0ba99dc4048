# One interface target carries the flags of every target of ours; nothing is set globally. In a group of sources
# (CMMLIVE_UNITY) a name of one shadows nothing of another.
add_library(cmm_options INTERFACE)
target_compile_features(cmm_options INTERFACE cxx_std_20)
target_compile_options(cmm_options INTERFACE -Wall -Wextra -Wpedantic
    $<$<NOT:$<BOOL:$<TARGET_PROPERTY:UNITY_BUILD>>>:-Wshadow> -Wconversion -Wno-sign-conversion
    -Wnon-virtual-dtor -Wold-style-cast -Woverloaded-virtual -ffp-contract=off)
# GCC 12 sees an overlap in "literal" + std::string (its bug 105651).
target_compile_options(cmm_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
if(CMMLIVE_WERROR)
    target_compile_options(cmm_options INTERFACE -Werror)
endif()
target_compile_definitions(cmm_options INTERFACE EIGEN_MPL2_ONLY)
# What is instrumented: the layers and the program; the tests' own code where CMMLIVE_SANITIZE_TESTS says so.
add_library(cmm_sanitized INTERFACE)
if(CMMLIVE_SANITIZE)
    target_link_options(cmm_options INTERFACE -fsanitize=${CMMLIVE_SANITIZE})
    target_compile_options(cmm_sanitized INTERFACE -fsanitize=${CMMLIVE_SANITIZE} -fno-omit-frame-pointer -O1 -g1 -UNDEBUG)
    # Eigen pads its memory under the address sanitizer: what frees it must agree, instrumented or not.
    target_compile_definitions(cmm_sanitized INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
    # GCC 12 takes Asio's inlined coroutine frame allocator for a mismatched new/delete when it instruments.
    target_compile_options(cmm_sanitized INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-mismatched-new-delete>)
    # Asio's fences are beside its mutexes; that the thread sanitizer does not see them is no finding.
    if(CMMLIVE_SANITIZE MATCHES "thread")
        target_compile_options(cmm_sanitized INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-tsan>)
    endif()
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMMLIVE_SANITIZE MATCHES "undefined")
        # These four double the time to compile; a null pointer is the address sanitizer's, x86 needs no alignment.
        target_compile_options(cmm_sanitized INTERFACE -fno-sanitize-recover=undefined
            -fno-sanitize=null,alignment,object-size,vptr)
    endif()
endif()
# In a group each source is an included file: GCC 12 then minds members of unnamed namespaces that it lets pass elsewhere.
if(CMMLIVE_UNITY STREQUAL "all")
    target_compile_options(cmm_sanitized INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endif()
if(CMMLIVE_COVERAGE)
    target_compile_options(cmm_options INTERFACE --coverage -fprofile-update=atomic)
    target_link_options(cmm_options INTERFACE --coverage)
endif()
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM} CACHE STRING "" FORCE)
endif()
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
