#pragma once
/// The frame of every page, which is a self-contained HTML file without network.

#include <string>
#include <string_view>
#include <vector>

#include "piste/plot/figure.h"

namespace piste::page {

/// A part of a page with its heading. Links to it use `name`.
struct Section {
  std::string name, heading, body;  ///< the body is markup
};

using Row = std::vector<std::string>;

/// A table of plain text. The first column has names, the others have numbers.
std::string table(std::string_view caption, const Row& head, const std::vector<Row>& rows);

/// Makes a table scroll if the page is too narrow.
std::string wide(std::string_view table);

/// Pictures with their captions below them.
std::string pictures(const std::vector<Figure>& figures);

/// Sentences of plain text under a heading. Empty if there are none.
std::string list(std::string_view heading, const std::vector<std::string>& items);

/// A number that stands out at the head of a page, with a note below it; `value` may be markup.
std::string tile(std::string_view name, std::string_view value, std::string_view note);
std::string tiles(const std::vector<std::string>& tiles);

/// Warnings of a run, at the head of a page; folded if they are many. Empty if there are none.
std::string warnings(const std::vector<std::string>& warnings);

/// A page.
struct Page {
  std::string title, subtitle;  ///< plain text, and a line of markup below it
  std::string head = {};        ///< markup before the sections: what was reached, warnings, the first screen
  std::vector<Section> sections;
  std::string style = {}, scripts = {};
};

/// The whole page: title, subtitle, links to the sections that have a body, head and sections. Figures are numbered.
std::string render(const Page& page);

/// The styles of the libraries that draw.
std::string styles();

}  // namespace piste::page
