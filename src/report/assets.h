#pragma once
/// Text files that CMake embeds into the library (cmake/EmbedText.cmake), so that a report is self-contained.

#include <string_view>

namespace piste::assets {

std::string_view
dygraphs_js();  ///< the plotting library, MIT licence; empty where it was not there when this was built
std::string_view dygraphs_css();
std::string_view leaflet_js();  ///< the plan's library, BSD-2 licence; empty likewise
std::string_view leaflet_css();
std::string_view
page_js();  ///< draws plan and charts from the numbers in the page: the parts of src/report/assets/page
std::string_view report_css();

}  // namespace piste::assets
