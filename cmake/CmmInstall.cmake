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
# The cell as a service (docs/cell.md): its unit, an example of its options, and what machine files refer to.
if(TARGET cmmlive)
    configure_file(${PROJECT_SOURCE_DIR}/config/systemd/cmmlive-cell.service.in ${CMAKE_BINARY_DIR}/cmmlive-cell.service @ONLY)
    install(FILES ${CMAKE_BINARY_DIR}/cmmlive-cell.service DESTINATION lib/systemd/system)
    install(FILES ${PROJECT_SOURCE_DIR}/config/systemd/cell.conf DESTINATION ${CMAKE_INSTALL_DATADIR}/cmmlive)
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/config DESTINATION ${CMAKE_INSTALL_DATADIR}/cmmlive PATTERN systemd EXCLUDE)
    install(FILES ${PROJECT_SOURCE_DIR}/docs/cell.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
endif()
