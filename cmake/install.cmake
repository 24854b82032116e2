# `cmake --install`: the program, the libraries, their headers, and a package for find_package(Parhelion).
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Parhelion)
set(layers base image sampling bvh scene gpu frame scene_gpu passes renderers session)
list(TRANSFORM layers PREPEND parhelion_ OUTPUT_VARIABLE layer_targets)

install(TARGETS parhelion RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS ${layer_targets} parhelion_shaders_embedded EXPORT ParhelionTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY src/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/parhelion FILES_MATCHING PATTERN "*.h" PATTERN "internal.h" EXCLUDE PATTERN "app" EXCLUDE)
install(DIRECTORY shaders/shared shaders/lib DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/parhelion FILES_MATCHING PATTERN "*.h" PATTERN "*.glsl")
install(EXPORT ParhelionTargets NAMESPACE Parhelion:: DESTINATION ${package_dir})
configure_package_config_file(cmake/ParhelionConfig.cmake.in ${CMAKE_BINARY_DIR}/ParhelionConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/ParhelionConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/ParhelionConfig.cmake ${CMAKE_BINARY_DIR}/ParhelionConfigVersion.cmake DESTINATION ${package_dir})
