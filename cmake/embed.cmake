# Called by embed_texts(). Writes the generated source file OUT with the contents of all TEXTS.
set(text "#include \"${HEADER}\"\n#include <stdexcept>\nnamespace whorl {\nstd::string ${FUNCTION}(const std::string& name) {\n")
foreach(file IN LISTS TEXTS)
  get_filename_component(name ${file} NAME)
  file(READ ${file} body)
  string(APPEND text "    if (name == \"${name}\")\n        return R\"EMBEDDED(${body})EMBEDDED\";\n")
endforeach()
string(APPEND text "    throw std::logic_error(\"nothing named \" + name + \" is embedded\");\n}\n}  // namespace whorl\n")
file(WRITE ${OUT} "${text}")
