# Writes OUTPUT, the .cpp of page_files.h, from the files in WEB:
#   cmake -DWEB=folder -DOUTPUT=file -P embed.cmake
set(arrays "")
set(entries "")

macro(embed NAME PATH TYPE FILE)
  file(READ ${WEB}/${FILE} bytes HEX)
  string(REGEX REPLACE "(................................)" "\\1\n" bytes "${bytes}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${bytes}")
  string(APPEND arrays "constexpr char k${NAME}[] = {\n${bytes}'\\0'};\n")
  string(APPEND entries
         "    PageFile{\"${PATH}\", \"${TYPE}\", {k${NAME}, sizeof(k${NAME}) - 1}},\n")
endmacro()

embed(Page / "text/html; charset=utf-8" index.html)
embed(Style /view.css "text/css; charset=utf-8" view.css)
embed(Script /view.js "text/javascript; charset=utf-8" dist/view.js)
embed(Licences /LICENSES.txt "text/plain; charset=utf-8" dist/LICENSES.txt)

file(WRITE ${OUTPUT} "// Made by embed.cmake.
#include \"client/view/page_files.h\"

namespace eifmap {
namespace {

${arrays}
constexpr PageFile kFiles[] = {
${entries}};

}  // namespace

std::span<const PageFile> page_files() {
  return kFiles;
}

}  // namespace eifmap
")
