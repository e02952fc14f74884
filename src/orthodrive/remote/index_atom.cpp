// SPDX-License-Identifier: Apache-2.0
// Feeds of INSPIRE download services: a service feed leads to datasets, these to files.
#include <fmt/format.h>

#include <algorithm>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/remote/http/url_template.hpp"
#include "orthodrive/remote/sheet_indices.hpp"
#include "orthodrive/remote/sheets/atom_feed.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive::remote {
namespace {
constexpr int deepest_feed = 4;
constexpr std::size_t most_feeds = 2000, most_files_without_place = 8;

class AtomWalk {
 public:
  AtomWalk(const FetchJob& job, const SheetArea& area)
      : job_(job), area_(area), url_(job.secrets.resolve(job.source.url)), keys_(job.source.url, url_) {
    for (std::size_t at = 0; at < job.source.layer.size();) {
      const std::size_t end = std::min(job.source.layer.find(' ', at), job.source.layer.size());
      if (end > at) words_.push_back(roadquery::lowered(job.source.layer.substr(at, end - at)));
      at = end + 1;
    }
  }

  std::vector<Sheet> run() {
    visit(url_, {{}, "", "", words_.empty(), 0});
    if (sheets_.empty() && !words_.empty() && !titles_.empty()) {
      const std::vector<std::string> titles(titles_.begin(), titles_.end());
      throw InputError(job_.secrets.hide(url_),
                       fmt::format("nothing that touches the area is called '{}'; there are: {}", job_.source.layer,
                                   fmt::join(titles, "; ")));
    }
    return std::move(sheets_);
  }

 private:
  /// What the feeds above say of a feed.
  struct Above {
    MultiPolygon footprint;
    std::string crs, updated;
    bool chosen = false;  ///< the layer is it or lies above it
    int depth = 0;
  };

  void visit(const std::string& url, const Above& above) {
    if (!visited_.insert(url).second) return;
    const std::string shown = job_.secrets.hide(url);
    if (visited_.size() > most_feeds)
      throw InputError(
          shown,
          fmt::format("more than {} feeds touch the area; take a smaller area, or one dataset: layer", most_feeds));
    const AtomFeed feed = parse_atom_feed(job_.client.get({.url = url}).body, shown);
    std::vector<bool> named;
    named.reserve(feed.entries.size());
    for (const AtomEntry& entry : feed.entries)
      named.push_back(!above.chosen && is_called(entry.title + " " + entry.id + " " + entry.code));
    const bool any_named = std::find(named.begin(), named.end(), true) != named.end();
    for (std::size_t i = 0; i < feed.entries.size(); ++i)
      if (!any_named || named[i]) visit_entry(feed, feed.entries[i], {url, shown}, above, named[i]);
    for (const AtomLink& link : feed.links)  // of feeds in parts (RFC 5005)
      if (link.rel == "next") follow(url, shown, link.href, above);
  }

  struct Page {
    const std::string& url;
    const std::string& shown;
  };

  void visit_entry(const AtomFeed& feed, const AtomEntry& entry, const Page& page, const Above& above, bool named) {
    Above here = above;
    here.chosen = above.chosen || named, ++here.depth;
    if (!entry.footprint.empty())
      here.footprint = entry.footprint;
    else if (!feed.footprint.empty() && above.footprint.empty())
      here.footprint = feed.footprint;
    if (!here.footprint.empty() && !area_.touches(here.footprint)) return;
    if (!entry.crs.empty()) here.crs = entry.crs;
    if (!entry.updated.empty()) here.updated = entry.updated;
    if (titles_.size() < 12) titles_.insert(printable(entry.title).substr(0, 60));
    std::size_t without_place = 0;
    for (const AtomLink& link : entry.links) {
      if (leads_to_feed(link)) {
        if (here.depth >= deepest_feed)
          throw InputError(page.shown, fmt::format("leads on to more than {} feeds below each other", deepest_feed));
        follow(page.url, page.shown, link.href, here);
      } else if (leads_to_sheet(link)) {
        take(entry, link, page, here, without_place);
      }
    }
  }

  void take(const AtomEntry& entry, const AtomLink& link, const Page& page, const Above& here,
            std::size_t& without_place) {
    if (!here.chosen && !is_called(link.title + " " + link.href)) return;
    const std::string type = link.type.substr(0, link.type.find(';'));
    if (!job_.source.format.empty() && roadquery::lowered(job_.source.format) != type) return;
    Sheet sheet{.url = sheet_address(job_, keys_, page.url, link.href),
                .footprint = here.footprint,
                .crs = here.crs,
                .type = type,
                .date = here.updated,
                .bytes = link.bytes};
    if (const auto box = box_of_link(link, here.footprint)) {
      sheet.footprint = {*box};
      if (!area_.touches(sheet.footprint)) return;
    } else if (++without_place > most_files_without_place) {
      throw InputError(
          page.shown,
          fmt::format("entry '{}' has more than {} files and does not say where they lie (bbox); name those "
                      "of the area in 'urls' of kind \"raster\"",
                      printable(entry.title).substr(0, 60), most_files_without_place));
    }
    add_sheet(sheets_, std::move(sheet), page.shown);
  }

  void follow(const std::string& url, const std::string& shown, const std::string& href, const Above& above) {
    const std::string address = absolute_address(url, href);
    if (address.empty())
      throw InputError(
          shown, fmt::format("leads to '{}', which is no address of http or https", printable(href).substr(0, 80)));
    visit(keys_.with(address), above);
  }

  [[nodiscard]] bool is_called(const std::string& text) const {
    const std::string lowered = roadquery::lowered(text);
    return !words_.empty() && std::all_of(words_.begin(), words_.end(), [&](const std::string& word) {
      return lowered.find(word) != std::string::npos;
    });
  }

  const FetchJob& job_;
  const SheetArea& area_;
  std::string url_;
  LinkKeys keys_;
  std::vector<std::string> words_;
  std::set<std::string> visited_, titles_;
  std::vector<Sheet> sheets_;
};
}  // namespace

std::vector<Sheet> atom_sheets(const FetchJob& job, const SheetArea& area) { return AtomWalk(job, area).run(); }

}  // namespace orthodrive::remote
