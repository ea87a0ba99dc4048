# What another project uses: cmm::core and cmm::fitting (headers, archives, package file). The executable goes along.
include(CMakePackageConfigHelpers)
install(TARGETS cmm_core cmm_fitting EXPORT cmmlive_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
foreach(layer core fitting)
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/${layer} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cmmlive
        FILES_MATCHING PATTERN "*.hpp")
endforeach()
install(EXPORT cmmlive_targets NAMESPACE cmm:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/cmmlive)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/cmmliveConfig.cmake.in ${CMAKE_BINARY_DIR}/cmmliveConfig.cmake
    INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/cmmlive)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/cmmliveConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/cmmliveConfig.cmake ${CMAKE_BINARY_DIR}/cmmliveConfigVersion.cmake
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/cmmlive)
if(TARGET cmmlive)
    install(TARGETS cmmlive RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
