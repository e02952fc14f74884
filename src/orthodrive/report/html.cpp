// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/report/html.hpp"

#include <fmt/format.h>

#include "orthodrive/core/escape_xml.hpp"

namespace orthodrive {

const char* const html_style = R"(
:root{color-scheme:light;font:16px/1.5 system-ui,"Segoe UI",Roboto,"Helvetica Neue",sans-serif;color:#1d2530;background:#f4f5f7}
body{margin:0}header{background:#16222e;color:#fff;padding:2.2rem 0}header h1{margin:0;font-size:2rem}header p{margin:.3rem 0 0;color:#b8c4d0}
main,header>div{max-width:1000px;margin:auto;padding:0 1rem}h2{margin:2.6rem 0 .6rem;border-bottom:2px solid #ff7a00;padding-bottom:.2rem}
.tiles{display:flex;flex-wrap:wrap;gap:.8rem;margin-top:1.4rem}.tiles div{background:#223344;border-radius:6px;padding:.6rem 1rem;min-width:7rem}
.tiles b{display:block;font-size:1.35rem}.tiles span{color:#b8c4d0;font-size:.85rem}
figure{margin:1rem 0}img,svg{max-width:100%;height:auto;display:block;border-radius:4px;background:#fff}figcaption{font-size:.85rem;color:#5a6673;margin-top:.25rem}
.row{display:grid;grid-template-columns:repeat(auto-fill,minmax(300px,1fr));gap:1rem}
table{border-collapse:collapse;margin:1rem 0;font-variant-numeric:tabular-nums;background:#fff}th,td{padding:.3rem .8rem;border-bottom:1px solid #dde2e7;text-align:left}
td.n{text-align:right}th{background:#e9edf1}.legend span{margin-right:1rem;white-space:nowrap}.legend i{display:inline-block;width:1em;height:1em;border-radius:3px;margin-right:.35em;vertical-align:-.12em}
.bar span{display:inline-block;width:12rem;height:.8rem;border-radius:3px;vertical-align:middle}footer{max-width:1000px;margin:3rem auto 2rem;padding:0 1rem;color:#5a6673;font-size:.85rem}
)";

std::string base64(const std::vector<std::uint8_t>& bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < n ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= n ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string html_figure(const std::vector<std::uint8_t>& picture, const std::string& type, const std::string& caption) {
  return fmt::format(
      "<figure><img alt=\"{0}\" src=\"data:image/{1};base64,{2}\"/><figcaption>{0}</figcaption></figure>\n",
      escape_xml(caption), type, base64(picture));
}

std::string html_table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<table><thead><tr>";
  for (const auto& cell : head) html += "<th>" + escape_xml(cell) + "</th>";
  html += "</tr></thead><tbody>";
  for (const auto& row : rows) {
    html += "<tr>";
    for (const auto& cell : row) {  // numbers stand to the right
      const bool number = !cell.empty() && cell.find_first_not_of("0123456789.-+e ") == std::string::npos;
      html += (number ? "<td class=\"n\">" : "<td>") + escape_xml(cell) + "</td>";
    }
    html += "</tr>";
  }
  return html + "</tbody></table>\n";
}

}  // namespace orthodrive
