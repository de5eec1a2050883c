# Files that people cite name the version of the project. cmake -DROOT=<tree> -DVERSION=1.2.3 -P version.cmake
cmake_minimum_required(VERSION 3.25)
foreach(place "CITATION.cff|\nversion: ${VERSION}\n" ".github/codemeta.json|\"version\": \"${VERSION}\""
    "README.md|Bipot ${VERSION}" "CHANGELOG.md|\n## ${VERSION}\n")
  string(REPLACE "|" ";" parts "${place}")
  list(GET parts 0 file)
  list(GET parts 1 words)
  file(READ ${ROOT}/${file} text)
  string(FIND "${text}" "${words}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "${file} does not name version ${VERSION}")
  endif()
endforeach()
