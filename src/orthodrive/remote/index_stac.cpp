// SPDX-License-Identifier: Apache-2.0
// STAC API: item search (https://api.stacspec.org/v1.0.0/item-search).
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "orthodrive/core/closest_word.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/remote/http/url_template.hpp"
#include "orthodrive/remote/sheet_indices.hpp"
#include "orthodrive/remote/sheets/stac_items.hpp"

namespace orthodrive::remote {
namespace {
using nlohmann::json;
constexpr int most_pages = 1000, most_pages_without_news = 10, items_of_page = 100;

struct StacRequest {
  std::string url, body;  ///< a body: POST
  friend bool operator<(const StacRequest& a, const StacRequest& b) {
    return std::pair(a.url, a.body) < std::pair(b.url, b.body);
  }
};

/// .../search, .../collections/NAME/items
std::string search_address(const std::string& url) {
  const std::size_t mark = std::min(url.find_first_of("?#"), url.size());
  std::string path = url.substr(0, mark);
  while (path.ends_with('/')) path.pop_back();
  const std::string parent = path.substr(0, path.rfind('/'));
  if (!path.ends_with("/search") && !path.ends_with("/items"))
    path += parent.ends_with("/collections") ? "/items" : "/search";
  return path + url.substr(mark);
}

std::string bbox_text(const Box2& b) {
  return fmt::format("{:.7f},{:.7f},{:.7f},{:.7f}", b.min_x, b.min_y, b.max_x, b.max_y);
}

StacRequest get_request(const FetchSource& source, const std::string& url, const SheetArea& area) {
  std::vector<std::pair<std::string, std::string>> query{{"bbox", bbox_text(area.box())},
                                                         {"limit", std::to_string(items_of_page)}};
  if (!source.time.empty()) query.emplace_back("datetime", source.time);
  return {with_query(url, query), ""};
}

/// The same question as a POST: parameters of the table's url become members of the body.
StacRequest post_request(const FetchSource& source, const std::string& url, const SheetArea& area) {
  const Box2& b = area.box();
  json body{{"bbox", {b.min_x, b.min_y, b.max_x, b.max_y}}, {"limit", items_of_page}};
  if (!source.time.empty()) body["datetime"] = source.time;
  const std::size_t mark = url.find('?');
  std::string kept;
  for (std::size_t at = mark == std::string::npos ? url.size() : mark + 1; at < url.size();) {
    const std::size_t end = std::min(url.find('&', at), url.size());
    const std::string part = url.substr(at, end - at), name = part.substr(0, part.find('='));
    const std::string value = part.find('=') == std::string::npos ? "" : part.substr(part.find('=') + 1);
    at = end + 1;
    if (name == "collections" || name == "ids") {
      for (std::size_t from = 0; from < value.size();) {
        const std::size_t to = std::min(value.find(',', from), value.size());
        body[name].push_back(value.substr(from, to - from));
        from = to + 1;
      }
    } else if (!part.empty()) {
      kept += (kept.empty() ? "?" : "&") + part;  // a key
    }
  }
  return {url.substr(0, mark) + kept, body.dump(-1, ' ', false, json::error_handler_t::replace)};
}

/// The walk over the pages of one search.
class StacSearch {
 public:
  StacSearch(const FetchJob& job, const SheetArea& area)
      : job_(job),
        area_(area),
        url_(search_address(job.secrets.resolve(job.source.url))),
        shown_(job.secrets.hide(url_)),
        keys_(job.source.url, url_) {}

  std::vector<Sheet> run() {
    std::optional<StacRequest> request = get_request(job_.source, url_, area_);
    std::set<StacRequest> asked;
    for (int pages = 1; request; ++pages) {
      if (!asked.insert(*request).second) throw InputError(shown_, "pages lead round in a circle; tell the provider");
      if (pages > most_pages)
        throw InputError(shown_, fmt::format("has more than {} pages; take a smaller area or say time", most_pages));
      const StacPage page = parse_stac_page(answer(*request), shown_);
      const std::size_t known = ids_.size();
      for (const StacItem& item : page.items) take(item, request->url);
      idle_pages_ = ids_.size() > known ? 0 : idle_pages_ + 1;
      if (page.next && idle_pages_ >= most_pages_without_news)
        throw InputError(
            shown_, fmt::format("pages without end: the last {} brought nothing new; tell the provider", idle_pages_));
      request = page.next ? std::optional(following(*request, *page.next)) : std::nullopt;
    }
    if (sheets_.empty() && without_asset_ > 0) throw InputError(shown_, no_asset());
    return std::move(sheets_);
  }

 private:
  /// A server that takes no GET is asked by POST from then on.
  std::string answer(StacRequest& request) {
    std::string body, wrong;
    int status = 0;
    const auto ask = [&] {
      bool asked = false;
      wrong.clear();
      HttpWork work;
      work.next = [&]() -> std::optional<HttpRequest> {
        if (std::exchange(asked, true)) return std::nullopt;
        return HttpRequest{
            .url = request.url, .post = request.body, .post_type = request.body.empty() ? "" : "application/json"};
      };
      work.take = [&](HttpReply&& reply) { body = std::move(reply.body), status = reply.status; };
      work.fail = [&](HttpFailure&& failure) { wrong = std::move(failure.what), status = failure.status; };
      (void)job_.client.run(work);
    };
    ask();
    if (status == 405 && request.body.empty()) {
      request = post_request(job_.source, url_, area_);
      ask();
    }
    if (!wrong.empty()) throw Error(wrong);
    if (status == 404) throw InputError(shown_, "HTTP 404 (not there); check the url");
    return body;
  }

  StacRequest following(const StacRequest& request, const StacNext& next) const {
    const std::string url = keys_.with(absolute_address(request.url, next.href));
    if (url.empty())
      throw InputError(shown_,
                       fmt::format("its next page is no address of http: {}", printable(next.href).substr(0, 80)));
    if (next.body.empty()) return {url, ""};
    return {url, next.merge ? merged_json(request.body, next.body) : next.body};
  }

  void take(const StacItem& item, const std::string& page) {
    const std::string id = item.id.empty() && !item.assets.empty() ? item.assets.front().href : item.id;
    if (!ids_.insert({item.collection, id}).second) return;
    if (!item.footprint.empty() && !area_.touches(item.footprint)) return;
    const StacAsset* asset = chosen_asset(item, job_.source.layer, shown_);
    if (!asset) {
      ++without_asset_;
      for (const StacAsset& other : item.assets)
        if (known_keys_.size() < 100) known_keys_.insert(printable(other.key).substr(0, 40));
      return;
    }
    add_sheet(sheets_,
              {sheet_address(job_, keys_, page, asset->href), item.footprint,
               asset->crs.empty() ? item.crs : asset->crs, "", item.date, asset->bytes},
              shown_);
  }

  [[nodiscard]] std::string no_asset() const {
    const std::vector<std::string> keys(known_keys_.begin(), known_keys_.end());
    if (keys.empty()) return fmt::format("{} items of the area have no assets", without_asset_);
    return job_.source.layer.empty()
               ? fmt::format("no asset of the area is a raster, there are: {}; say which with layer",
                             fmt::join(keys, ", "))
               : fmt::format("no item of the area has an asset '{}'{}", job_.source.layer,
                             suggestion(job_.source.layer, keys));
  }

  const FetchJob& job_;
  const SheetArea& area_;
  std::string url_, shown_;
  LinkKeys keys_;
  std::vector<Sheet> sheets_;
  std::set<std::pair<std::string, std::string>> ids_;  ///< collection, id
  std::set<std::string> known_keys_;
  std::size_t without_asset_ = 0;
  int idle_pages_ = 0;
};
}  // namespace

std::vector<Sheet> stac_sheets(const FetchJob& job, const SheetArea& area) { return StacSearch(job, area).run(); }

}  // namespace orthodrive::remote
