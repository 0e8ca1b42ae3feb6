#pragma once
/// The frame of every page: one HTML file that needs nothing beside it and no network.

#include <string>
#include <string_view>
#include <vector>

#include "piste/plot/figure.h"

namespace piste::page {

/// A part of a page under its heading. `name` stands in links to it.
struct Section {
  std::string name, heading, body;  ///< the body is markup
};

using Row = std::vector<std::string>;

/// A table of plain text: the first column names, the others are numbers.
std::string table(std::string_view caption, const Row& head, const std::vector<Row>& rows);

/// A table that scrolls by itself where the page is too narrow.
std::string wide(std::string_view table);

/// Pictures with their captions below them.
std::string pictures(const std::vector<Figure>& figures);

/// Sentences of plain text under a heading; nothing where there are none.
std::string list(std::string_view heading, const std::vector<std::string>& items);

/// The title, a line of markup below it, links to the sections, and the sections. `style` goes before the style of
/// all pages, `scripts` to the end.
std::string render(std::string_view title, std::string_view subtitle, const std::vector<Section>& sections,
                   std::string_view style = {}, std::string_view scripts = {});

}  // namespace piste::page
