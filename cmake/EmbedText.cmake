# Embeds text files: piste_embed(TARGET NAME FILE…) defines `std::string_view piste::assets::NAME()`, which the room that
# uses it declares, as src/report/assets.h does: the files one after the other, an empty text without any. Raw string
# pieces of at most 8 kB, because compilers limit the length of one literal.
function(piste_embed target name)
  set(text "")
  foreach(file ${ARGN})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
    file(READ ${file} part)
    string(APPEND text "${part}")
  endforeach()
  string(REGEX REPLACE "\n(//|/\\*)# sourceMappingURL=[^\n]*" "" text "${text}")
  string(REGEX REPLACE "url\\([^)]*\\)" "none" text "${text}")  # nothing is fetched when a page opens,
  string(REGEX REPLACE "href=\"https?://[^\"]*\"" "href=\"#\"" text "${text}")  # and nothing leads away from it
  set(pieces "")
  string(LENGTH "${text}" length)
  foreach(begin RANGE 0 ${length} 8000)
    string(SUBSTRING "${text}" ${begin} 8000 piece)
    string(APPEND pieces "R\"piste(${piece})piste\"\n")
  endforeach()
  set(unit ${PROJECT_BINARY_DIR}/generated/${name}.cpp)
  file(CONFIGURE OUTPUT ${unit} @ONLY CONTENT
"// Generated from ${ARGN} by cmake/EmbedText.cmake.
#include <string_view>
#pragma GCC diagnostic ignored \"-Woverlength-strings\"  // the standard promises 64 kB; GCC and clang take any length
namespace piste::assets {
std::string_view @name@();
std::string_view @name@() {
  static constexpr std::string_view kText =
@pieces@;
  return kText;
}
}  // namespace piste::assets
")
  target_sources(${target} PRIVATE ${unit})
endfunction()
