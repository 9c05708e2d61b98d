# embed_shaders(FOLDER RESULT): every GLSL file of FOLDER becomes a string in a generated source file, found by its file name through
# whorl::shader_source(name) (render/gl/shader_source.h).
function(embed_shaders folder result)
  file(GLOB shaders CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${folder}/*.glsl ${PROJECT_SOURCE_DIR}/${folder}/*.vert
       ${PROJECT_SOURCE_DIR}/${folder}/*.frag)
  set(generated ${PROJECT_BINARY_DIR}/generated/shaders.cpp)
  add_custom_command(OUTPUT ${generated}
    COMMAND ${CMAKE_COMMAND} "-DSHADERS=${shaders}" -DOUT=${generated} -P ${PROJECT_SOURCE_DIR}/cmake/embed.cmake
    DEPENDS ${shaders} ${PROJECT_SOURCE_DIR}/cmake/embed.cmake VERBATIM)
  set(${result} ${generated} PARENT_SCOPE)
endfunction()
