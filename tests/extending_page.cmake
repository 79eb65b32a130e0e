# SPDX-License-Identifier: MIT
# Reads the steps of docs/extending.md, for tests that follow them. SOURCE is the source tree.

# Sets `page` to a section of the page.
macro(open_section title)
  file(READ ${SOURCE}/docs/extending.md page)
  if(NOT page MATCHES "\n## ${title}\n")
    message(FATAL_ERROR "docs/extending.md has no section ${title}")
  endif()
  string(REGEX REPLACE ".*\n## ${title}\n" "" page "${page}")
  string(REGEX REPLACE "\n## .*" "" page "${page}")
endmacro()

# Sets `block` to the section's next block of code in this language, without its indentation.
macro(next_block language)
  if(NOT page MATCHES "   ```${language}\n([^`]*)   ```\n")
    message(FATAL_ERROR "docs/extending.md shows no further code in ${language}")
  endif()
  set(block "\n${CMAKE_MATCH_1}")
  string(REPLACE "${CMAKE_MATCH_0}" "" page "${page}")
  string(REPLACE "\n   " "\n" block "${block}")
  string(REGEX REPLACE "^\n" "" block "${block}")
endmacro()

# Replaces a pattern that `text`, the content of a file, has once.
function(edit file pattern replacement)
  string(REGEX MATCHALL "${pattern}" found "${text}")
  list(LENGTH found count)
  if(NOT count EQUAL 1)
    message(FATAL_ERROR "${file} has ${count} places like ${pattern}")
  endif()
  string(REGEX REPLACE "${pattern}" "${replacement}" text "${text}")
  set(text "${text}" PARENT_SCOPE)
endfunction()
