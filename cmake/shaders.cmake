# Shaders: every entry file is compiled by glslc in each of its declared variants, with dependencies and warnings as errors,
# checked by spirv-val, reflected and joined into one pack by tools/shader_pack.cpp.
#
#   name.comp                     a compute pass
#   name.trace                    a tracing pass: compiled in all three ways (query, compute, pipeline)
#   name.rchit|.rahit|.rmiss      the scene's hit shaders
#   name.vert and name.frag       a raster pass
#   a line "// variants: A B+C"   also compiled with -DA, and with -DB -DC
#   "// pipeline variants: ..."    of a .trace file: those of the pipeline way only
#   variant~                      of the compute way, after spirv-opt, for GPUs: an eighth faster there, a fifth slower on a CPU device;
#                                 of a compute pass too that says "// optimised variants", there with -DFOR_GPU
set(PARHELION_SHADER_ROOT ${CMAKE_SOURCE_DIR}/shaders)

add_executable(shader_pack tools/shader_pack.cpp)
target_include_directories(shader_pack SYSTEM PRIVATE ${SPIRV_CROSS_INCLUDE_DIR})
target_link_libraries(shader_pack PRIVATE ${SPIRV_CROSS_LIBRARY} parhelion_options fmt::fmt)
add_executable(embed_file tools/embed_file.cpp)
target_link_libraries(embed_file PRIVATE parhelion_options zstd::libzstd_shared)

# Compiles one source into ${shader_dir}/ID.spv.
function(parhelion_spirv source id stage comment)
    set(spv ${shader_dir}/${id}.spv)
    add_custom_command(OUTPUT ${spv}
        COMMAND ${Vulkan_GLSLC_EXECUTABLE} --target-env=vulkan1.3 -Werror -fshader-stage=${stage} ${ARGN}
            -I ${PARHELION_SHADER_ROOT} -I ${CMAKE_SOURCE_DIR}/src/passes -MD -MF ${spv}.d -o ${spv} ${source}
        COMMAND ${SPIRV_VAL} --target-env vulkan1.3 --scalar-block-layout ${spv}
        DEPENDS ${source} DEPFILE ${spv}.d COMMENT "${comment}" VERBATIM)
endfunction()

# A shader of the pack: appends "stage name variant path" to the manifest and the file to the outputs.
function(parhelion_compile_shader source name variant stage)
    string(MAKE_C_IDENTIFIER "${name}.${variant}.${stage}" id)
    parhelion_spirv(${source} ${id} ${stage} "Shader ${name} ${variant}" ${ARGN})
    set(shader_outputs ${shader_outputs} ${shader_dir}/${id}.spv PARENT_SCOPE)
    set(shader_manifest "${shader_manifest}${name}\t${variant}\t${stage}\t${shader_dir}/${id}.spv\n" PARENT_SCOPE)
endfunction()

# variant~: of the same SPIR-V, or where there are flags of the source compiled with them, after spirv-opt.
function(parhelion_optimize_shader source name variant stage)
    string(MAKE_C_IDENTIFIER "${name}.${variant}.${stage}" id)
    if(ARGN)
        set(id ${id}.gpu)
        parhelion_spirv(${source} ${id} ${stage} "Shader ${name} ${variant} for GPUs" ${ARGN})
    endif()
    set(optimized ${shader_dir}/${id}.optimized.spv)
    add_custom_command(OUTPUT ${optimized}
        COMMAND ${SPIRV_OPT} -O --preserve-bindings ${shader_dir}/${id}.spv -o ${optimized}
        COMMAND ${SPIRV_VAL} --target-env vulkan1.3 --scalar-block-layout ${optimized}
        DEPENDS ${shader_dir}/${id}.spv COMMENT "Shader ${name} ${variant}~" VERBATIM)
    set(shader_outputs ${shader_outputs} ${optimized} PARENT_SCOPE)
    set(shader_manifest "${shader_manifest}${name}\t${variant}~\t${stage}\t${optimized}\n" PARENT_SCOPE)
endfunction()

# parhelion_shader_pack(PACK folder=prefix...): PACK.pack in the build folder and a library parhelion_PACK_embedded with its
# bytes. A shader's name is its path below `folder` without extension, with `prefix` in front.
function(parhelion_shader_pack pack)
    set(shader_dir ${CMAKE_BINARY_DIR}/shaders/${pack})
    file(MAKE_DIRECTORY ${shader_dir})
    set(shader_outputs)
    set(shader_manifest)
    foreach(pair ${ARGN})
        string(REGEX REPLACE "=.*" "" root ${pair})
        string(REGEX REPLACE ".*=" "" prefix ${pair})
        file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${root}/*.comp ${root}/*.trace ${root}/*.rchit ${root}/*.rahit ${root}/*.rmiss
             ${root}/*.vert ${root}/*.frag)
        foreach(source ${sources})
            file(RELATIVE_PATH path ${root} ${source})
            string(REGEX REPLACE "\\.[a-z]+$" "" name ${prefix}${path})
            string(REGEX MATCH "[a-z]+$" kind ${source})
            file(STRINGS ${source} declared REGEX "^// variants: ")
            string(REGEX REPLACE "^// variants: " "" declared "${declared}")
            separate_arguments(declared)
            file(STRINGS ${source} pipeline_only REGEX "^// pipeline variants: ")
            string(REGEX REPLACE "^// pipeline variants: " "" pipeline_only "${pipeline_only}")
            separate_arguments(pipeline_only)
            file(STRINGS ${source} optimised REGEX "^// optimised variants$")
            foreach(define "" ${declared} ${pipeline_only})
                set(flags)
                set(suffix)
                if(define)
                    string(REGEX REPLACE "([A-Z_]+)\\+?" "-D\\1;" flags ${define})
                    set(suffix "+${define}")
                endif()
                if(kind STREQUAL "comp")
                    parhelion_compile_shader(${source} ${name} "${suffix}" compute ${flags})
                    if(optimised)
                        parhelion_optimize_shader(${source} ${name} "${suffix}" compute -DFOR_GPU ${flags})
                    endif()
                elseif(kind STREQUAL "trace" AND define AND define IN_LIST pipeline_only)
                    parhelion_compile_shader(${source} ${name} "pipeline${suffix}" rgen -DTRACE_PIPELINE ${flags})
                elseif(kind STREQUAL "trace")
                    parhelion_compile_shader(${source} ${name} "query${suffix}" compute -DTRACE_QUERY ${flags})
                    parhelion_compile_shader(${source} ${name} "compute${suffix}" compute -DTRACE_COMPUTE ${flags})
                    parhelion_optimize_shader(${source} ${name} "compute${suffix}" compute)
                    parhelion_compile_shader(${source} ${name} "pipeline${suffix}" rgen -DTRACE_PIPELINE ${flags})
                elseif(kind STREQUAL "vert" OR kind STREQUAL "frag")
                    parhelion_compile_shader(${source} ${name} "${suffix}" ${kind} ${flags})
                else()
                    parhelion_compile_shader(${source} ${name} "${suffix}" ${kind} -DTRACE_PIPELINE ${flags})
                endif()
            endforeach()
        endforeach()
    endforeach()
    file(CONFIGURE OUTPUT ${shader_dir}/manifest.tsv CONTENT "${shader_manifest}" @ONLY)
    add_custom_command(OUTPUT ${shader_dir}/${pack}.pack
        COMMAND shader_pack ${shader_dir}/manifest.tsv ${shader_dir}/${pack}.pack
        DEPENDS shader_pack ${shader_outputs} ${shader_dir}/manifest.tsv VERBATIM)
    set(packed)
    if(pack STREQUAL "shaders")  # the one that ships is packed: a quarter of the size
        set(packed zstd)
    endif()
    add_custom_command(OUTPUT ${shader_dir}/${pack}.cpp
        COMMAND embed_file ${shader_dir}/${pack}.pack ${shader_dir}/${pack}.cpp ${pack} ${packed}
        DEPENDS embed_file ${shader_dir}/${pack}.pack VERBATIM)
    add_library(parhelion_${pack}_embedded STATIC ${shader_dir}/${pack}.cpp)
endfunction()
