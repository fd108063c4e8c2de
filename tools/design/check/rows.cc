// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/check/rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "tools/escape.hpp"

namespace mlcca::tools::design {

Rows::Rows(std::string title, std::vector<const char*> columns)
    : title_(std::move(title)), columns_(std::move(columns)) {}

bool Rows::wants_more() {
  ++all_;
  return all_ <= kMaxRows;
}

void Rows::add(const std::vector<std::string>& cells, std::string_view kind, std::string_view id) {
  const auto out = std::back_inserter(body_);
  fmt::format_to(out, R"(<tr role="row" class="{}"{}>)", kind,
                 id.empty() ? "" : fmt::format(R"( id="{}")", id));
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (i == 0)
      fmt::format_to(out, R"(<th scope="row" role="rowheader">{}</th>)", cells[i]);
    else
      fmt::format_to(out, R"(<td role="cell" data-label="{}"><div>{}</div></td>)", columns_[i],
                     cells[i]);
  body_ += "</tr>\n";
}

std::string Rows::html(std::string_view before) const {
  if (all_ == 0) return {};
  std::string head;
  for (const auto* column : columns_)
    head += fmt::format(R"(<th scope="col" role="columnheader">{}</th>)", column);
  auto out = fmt::format(
      "<div class=\"card\">\n<h3>{0} <span class=\"quiet\">({1})</span></h3>\n{2}"
      "<table class=\"sheet\" role=\"table\" aria-label=\"{0}\">\n<thead role=\"rowgroup\">"
      "<tr role=\"row\">{3}</tr></thead>\n<tbody role=\"rowgroup\">\n{4}</tbody>\n</table>\n",
      title_, all_, before, head, body_);
  if (all_ > kMaxRows)
    out += fmt::format("<p class=\"quiet\">{} more are not shown</p>\n", all_ - kMaxRows);
  return out + "</div>\n";
}

Said said(Outcome outcome) {
  switch (outcome) {
    case Outcome::fit:
      return {"✓", "fits", "fit"};
    case Outcome::run_time:
      return {"◌", "decided at run time", "run-time"};
    case Outcome::unfit:
      break;
  }
  return {"✕", "does not fit", "unfit"};
}

std::string verdict(const Said& said) {
  return fmt::format(R"(<span class="outcome {}"><span aria-hidden="true">{}</span> {}</span>)",
                     said.kind, said.mark, said.word);
}

std::string meter(std::uint64_t ppm, std::uint64_t limit_ppm) {
  const auto part = static_cast<double>(ppm);
  const auto limit = static_cast<double>(std::max<std::uint64_t>(limit_ppm, 1));
  return fmt::format(
      R"(<span class="meter" aria-hidden="true"><span class="used" style="width:{:.1f}%"></span>)"
      "</span>{:.2f} %",
      std::min(100.0, 100.0 * part / limit), part / 10'000);
}

std::string path_text(std::string_view path) {
  std::string out;
  for (const char c : html_text(path)) {
    out += c;
    if (c == '/') out += "<wbr>";
  }
  return out;
}

}  // namespace mlcca::tools::design
