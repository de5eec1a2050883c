cmake_minimum_required(VERSION 3.25)
# Writes OUTPUT, a C++ source with the texts of page_files.h: the files of each list, one after the
# other. Numbers, since compilers limit the length of a string. A file LICENSE becomes a comment: the
# notice that has to stand in every page.
# cmake -DOUTPUT=page_files.cc -DPAGE=a.html -DSTYLE="a.css;b.css" -DSCRIPT="a.js;b.js" -P embed.cmake
set(source "#include \"bench/page/page_files.h\"\n\nnamespace bipot {\nnamespace {\n\n")
foreach(part PAGE STYLE SCRIPT)
  set(numbers "")
  foreach(file IN LISTS ${part})
    file(READ ${file} text HEX)
    if(file MATCHES "/LICENSE$")
      set(text "2f2a210a${text}2a2f")  # "/*!", a new line, "*/"
    endif()
    string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," text "${text}")
    string(APPEND numbers "${text}0x0a,")
  endforeach()
  string(REGEX REPLACE "((0x[0-9a-f]+,)(0x[0-9a-f]+,)(0x[0-9a-f]+,)(0x[0-9a-f]+,)(0x[0-9a-f]+,)(0x[0-9a-f]+,)(0x[0-9a-f]+,)(0x[0-9a-f]+,))" "\\1\n" numbers "${numbers}")
  string(APPEND source "const unsigned char k${part}[] = {\n${numbers}};\n\n")
endforeach()
string(APPEND source "template <std::size_t N>
std::string_view text_of(const unsigned char (&bytes)[N]) {
  return {reinterpret_cast<const char*>(bytes), N};
}

}  // namespace

PageFiles page_files() { return {text_of(kPAGE), text_of(kSTYLE), text_of(kSCRIPT)}; }

}  // namespace bipot
")
file(WRITE ${OUTPUT} "${source}")
