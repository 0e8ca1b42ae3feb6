#include "report/page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "plot/markup.h"
#include "report/assets.h"

namespace piste::page {

std::string table(std::string_view caption, const Row& head, const std::vector<Row>& rows) {
  std::string out = fmt::format("<table><caption>{}</caption>\n", escape_markup(caption));
  const auto line = [&out](const Row& cells, const char* tag) {
    out += "<tr>";
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const bool heading = i == 0 || *tag == 'h';
      out += fmt::format("<{0}{1}{2}>{3}</{0}>", heading ? "th" : "td",
                         heading ? (*tag == 'h' ? " scope=\"col\"" : " scope=\"row\"") : "",
                         i == 0 ? "" : " class=\"number\"", escape_markup(cells[i]));
    }
    out += "</tr>\n";
  };
  if (!head.empty()) line(head, "h");
  for (const Row& row : rows) line(row, "d");
  return out + "</table>\n";
}

std::string wide(std::string_view table) { return fmt::format("<div class=\"wide\">\n{}</div>\n", table); }

std::string pictures(const std::vector<Figure>& figures) {
  if (figures.empty()) return "<p>There is nothing to show.</p>\n";
  std::string out;
  for (const Figure& f : figures) {
    out += "<figure>\n" + f.svg;
    if (!f.caption.empty()) out += fmt::format("<figcaption>{}</figcaption>\n", escape_markup(f.caption));
    out += "</figure>\n";
  }
  return out;
}

std::string list(std::string_view heading, const std::vector<std::string>& items) {
  if (items.empty()) return {};
  std::string out = fmt::format("<p><strong>{}</strong></p>\n<ul>\n", heading);
  for (const std::string& item : items) out += fmt::format("<li>{}</li>\n", escape_markup(item));
  return out + "</ul>\n";
}

namespace {

/// Numbers the captions of all figures from 1.
void number_figures(std::string& markup) {
  constexpr std::string_view kFigure = "<figure>", kCaption = "<figcaption>", kEnd = "</figure>";
  int number = 0;
  for (std::size_t at = markup.find(kFigure); at != std::string::npos; at = markup.find(kFigure, at + 1)) {
    const std::size_t end = markup.find(kEnd, at), caption = markup.find(kCaption, at);
    if (end == std::string::npos) return;
    const std::string text = fmt::format("<b>Figure {}.</b> ", ++number);
    if (caption < end) {
      markup.insert(caption + kCaption.size(), text);
    } else {
      markup.insert(end, fmt::format("{}{}</figcaption>", kCaption, text));
    }
  }
}

}  // namespace

std::string tile(std::string_view name, std::string_view value, std::string_view note) {
  return fmt::format("<div class=\"tile\"><span>{}</span><b>{}</b><small>{}</small></div>\n", escape_markup(name),
                     value, escape_markup(note));
}

std::string tiles(const std::vector<std::string>& tiles) {
  return fmt::format("<div class=\"tiles\">\n{}</div>\n", fmt::join(tiles, ""));
}

std::string warnings(const std::vector<std::string>& warnings) {
  constexpr std::size_t kInView = 3;
  if (warnings.empty()) return {};
  std::string out =
      fmt::format("<details class=\"warnings\"{}><summary>{} warning{}</summary>\n<ul>\n",
                  warnings.size() > kInView ? "" : " open", warnings.size(), warnings.size() == 1 ? "" : "s");
  for (const std::string& warning : warnings) out += fmt::format("<li>{}</li>\n", escape_markup(warning));
  return out + "</ul></details>\n";
}

std::string styles() { return fmt::format("{}{}", assets::dygraphs_css(), assets::leaflet_css()); }

std::string render(const Page& page) {
  const std::string name = escape_markup(page.title);
  std::string out = "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  out += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  out += fmt::format("<title>{}</title>\n<style>\n{}{}</style>\n</head>\n<body>\n", name, page.style,
                     assets::report_css());
  out += fmt::format("<header><div><h1>{}</h1>\n<p class=\"soft\" id=\"subtitle\">{}</p></div>\n", name, page.subtitle);
  out += "<nav aria-label=\"Contents\">";
  for (const Section& s : page.sections) {
    if (!s.body.empty()) out += fmt::format("<a href=\"#{}\">{}</a>", s.name, s.heading);
  }
  out += fmt::format("</nav></header>\n<main>\n{}", page.head);
  for (const Section& s : page.sections) {
    if (!s.body.empty()) out += fmt::format("<h2 id=\"{}\">{}</h2>\n{}", s.name, s.heading, s.body);
  }
  number_figures(out);
  return out + fmt::format("</main>\n{}</body>\n</html>\n", page.scripts);
}

}  // namespace piste::page
