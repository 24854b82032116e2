# parhelion_library(NAME [USES layers...] [LINK public...] [LINK_PRIVATE private...]): one static library per folder under src/.
add_library(parhelion_options INTERFACE)
target_compile_options(parhelion_options INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Wno-missing-field-initializers
    $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>  # of a source that a unity build includes into another
    $<$<BOOL:${PARHELION_WARNINGS_AS_ERRORS}>:-Werror> -fno-fast-math -ffp-contract=off)
target_compile_definitions(parhelion_options INTERFACE GLM_FORCE_DEPTH_ZERO_TO_ONE GLM_FORCE_EXPLICIT_CTOR)

function(parhelion_library name)
    cmake_parse_arguments(arg "" "" "USES;LINK;LINK_PRIVATE" ${ARGN})
    file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/src/${name}/*.cpp ${CMAKE_SOURCE_DIR}/src/${name}/*.h)
    add_library(parhelion_${name} STATIC ${sources})
    set_target_properties(parhelion_${name} PROPERTIES LINKER_LANGUAGE CXX)
    target_include_directories(parhelion_${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/src> $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/shaders>
        $<INSTALL_INTERFACE:include/parhelion>)
    list(TRANSFORM arg_USES PREPEND parhelion_ OUTPUT_VARIABLE used)
    target_link_libraries(parhelion_${name} PUBLIC ${used} ${arg_LINK} PRIVATE ${arg_LINK_PRIVATE} $<BUILD_INTERFACE:parhelion_options>)
endfunction()

# parhelion_embed(LAYER NAME...): the bytes of src/LAYER/NAME.bin as parhelion::embedded::NAME (tools/embed_file.cpp).
function(parhelion_embed layer)
    foreach(name ${ARGN})
        set(input ${CMAKE_SOURCE_DIR}/src/${layer}/${name}.bin)
        set(output ${CMAKE_BINARY_DIR}/embedded/${name}.cpp)
        file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/embedded)
        add_custom_command(OUTPUT ${output} COMMAND embed_file ${input} ${output} ${name} DEPENDS embed_file ${input} VERBATIM)
        target_sources(parhelion_${layer} PRIVATE ${output})
    endforeach()
endfunction()
