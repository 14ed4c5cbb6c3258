# cmake -DOUTPUT=descriptors.cpp -DFILES=a.bin;b.bin -P embed_descriptors.cmake
# Writes a table of (message name, FileDescriptorSet bytes), the name being the file's without ".bin".
set(arrays "")
set(rows "")
foreach(file IN LISTS FILES)
  get_filename_component(name ${file} NAME)
  string(REGEX REPLACE "\\.bin$" "" name ${name})
  string(REPLACE "." "_" identifier ${name})
  file(READ ${file} hex HEX)
  string(LENGTH ${hex} digits)
  math(EXPR size "${digits} / 2")
  set(text "")
  set(at 0)
  while(at LESS digits)
    string(SUBSTRING ${hex} ${at} 64 piece)
    string(REGEX REPLACE "(..)" "\\\\x\\1" piece ${piece})
    string(APPEND text "\n    \"${piece}\"")
    math(EXPR at "${at} + 64")
  endwhile()
  string(APPEND arrays "constexpr char ${identifier}[] =${text};\n")
  string(APPEND rows "    {\"${name}\", {${identifier}, ${size}}},\n")
endforeach()
file(WRITE ${OUTPUT} "// Generated from proto/ by embed_descriptors.cmake.
#include \"schema/descriptors.h\"

namespace roseau::schema {
namespace {
${arrays}
constexpr DescriptorSet kSets[] = {
${rows}};
}  // namespace

std::span<const DescriptorSet> descriptor_sets() { return kSets; }

}  // namespace roseau::schema
")
