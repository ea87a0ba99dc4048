# cmm_layer(NAME sources... [PUBLIC libs...] [PRIVATE libs...]): one library = one layer = one folder, alias cmm::NAME.
# cmm_test(NAME sources... LIBS libs... [LABELS ...]): one GoogleTest executable, its cases registered with ctest.
function(cmm_layer name)
    cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
    add_library(cmm_${name} STATIC ${ARG_SOURCES})
    add_library(cmm::${name} ALIAS cmm_${name})
    set_target_properties(cmm_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
    target_include_directories(cmm_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
        $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/cmmlive>)
    target_compile_features(cmm_${name} PUBLIC cxx_std_20)
    target_link_libraries(cmm_${name} PUBLIC ${ARG_PUBLIC} PRIVATE $<BUILD_INTERFACE:cmm_options>
        $<BUILD_INTERFACE:cmm_sanitized> ${ARG_PRIVATE})
endfunction()

function(cmm_test name)
    cmake_parse_arguments(ARG "SERIAL" "TIMEOUT" "SOURCES;LIBS;LABELS" ${ARGN})
    add_executable(${name} ${ARG_SOURCES})
    target_link_libraries(${name} PRIVATE ${ARG_LIBS} cmm_options GTest::gtest GTest::gtest_main)
    if(CMMLIVE_SANITIZE_TESTS)
        target_link_libraries(${name} PRIVATE cmm_sanitized)
    endif()
    # The layers under test are optimised as users run them; of the tests' own code the compiler spares the time.
    target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
    # GCC 12 takes Asio's inlined coroutine frame allocator for a mismatched new/delete unless it inlines much.
    target_compile_options(${name} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-mismatched-new-delete>)
    if(NOT ARG_TIMEOUT)
        set(ARG_TIMEOUT 120)
    endif()
    set(properties TIMEOUT ${ARG_TIMEOUT})
    if(ARG_LABELS)
        list(APPEND properties LABELS "${ARG_LABELS}")
    endif()
    if(ARG_SERIAL)
        list(APPEND properties RUN_SERIAL TRUE)
    endif()
    gtest_discover_tests(${name} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} PROPERTIES ${properties}
        NO_PRETTY_VALUES DISCOVERY_TIMEOUT 60)
endfunction()
