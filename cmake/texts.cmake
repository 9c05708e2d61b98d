# embed_texts(FOLDER EXTENSIONS HEADER FUNCTION RESULT) embeds every file of FOLDER with one of the extensions as a string in a generated
# source file. whorl::FUNCTION(file name), declared in HEADER, returns the string. RESULT is set to the source file.
function(embed_texts folder extensions header function result)
  set(patterns ${extensions})
  list(TRANSFORM patterns PREPEND ${PROJECT_SOURCE_DIR}/${folder}/*.)
  file(GLOB texts CONFIGURE_DEPENDS ${patterns})
  set(generated ${PROJECT_BINARY_DIR}/generated/${function}.cpp)
  add_custom_command(OUTPUT ${generated}
    COMMAND ${CMAKE_COMMAND} "-DTEXTS=${texts}" -DHEADER=${header} -DFUNCTION=${function} -DOUT=${generated} -P ${PROJECT_SOURCE_DIR}/cmake/embed.cmake
    DEPENDS ${texts} ${PROJECT_SOURCE_DIR}/cmake/embed.cmake VERBATIM)
  set(${result} ${generated} PARENT_SCOPE)
endfunction()
