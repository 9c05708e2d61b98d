# Called by embed_shaders(): writes OUT with the text of each of SHADERS.
set(text "#include \"render/gl/shader_source.h\"\n#include <stdexcept>\nnamespace whorl {\nstd::string shader_source(const std::string& name) {\n")
foreach(file IN LISTS SHADERS)
  get_filename_component(name ${file} NAME)
  file(READ ${file} body)
  string(APPEND text "    if (name == \"${name}\")\n        return R\"GLSL(${body})GLSL\";\n")
endforeach()
string(APPEND text "    throw std::logic_error(\"no shader named \" + name);\n}\n}  // namespace whorl\n")
file(WRITE ${OUT} "${text}")
