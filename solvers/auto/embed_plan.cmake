cmake_minimum_required(VERSION 3.25)
# Writes OUTPUT, a C++ source with the text of INPUT for plan_text.h. Numbers, since compilers limit
# the length of a string. cmake -DINPUT=plan.toml -DOUTPUT=plan_text.cc -P embed_plan.cmake
file(READ ${INPUT} numbers HEX)
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," numbers "${numbers}")
string(REGEX REPLACE "(0a,)" "\\1\n" numbers "${numbers}")
file(WRITE ${OUTPUT} "#include \"solvers/auto/plan_text.h\"

namespace bipot {
namespace {

const unsigned char kText[] = {
${numbers}};

}  // namespace

std::string_view shipped_plan_text() {
  return {reinterpret_cast<const char*>(kText), sizeof(kText)};
}

}  // namespace bipot
")
