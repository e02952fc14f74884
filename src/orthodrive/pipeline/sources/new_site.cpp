// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/sources/new_site.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "orthodrive/core/closest_word.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/overlay.hpp"

namespace orthodrive {
namespace {

constexpr double whole = 0.999;               // share that counts as all of the area
constexpr double large_area_m2 = 30e6;        // more needs a machine with much memory
constexpr double memory_per_m2 = 8e9 / 23e6;  // of a build at 0.5 m/px, see `orthodrive build --help`
constexpr std::size_t most_corners = 2000;    // of an area in the site file

/// A TOML string.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      result += std::string{'\\', c};
    else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      result += fmt::format("\\u{:04X}", static_cast<unsigned char>(c));
    else
      result += c;
  }
  return result + "\"";
}

/// A source with what it is to this area.
struct Candidate {
  const CatalogueSource* source = nullptr;
  double coverage = 0.0;
};

class Chooser {
 public:
  /// `country`: that of the area's middle; empty: none.
  Chooser(const Catalogue& catalogue, const Polygon& lonlat, double area_km2, std::string country)
      : catalogue_(catalogue), lonlat_(lonlat), area_km2_(area_km2), country_(std::move(country)) {}

  /// By id, or the best; throws OptionError when there is none.
  [[nodiscard]] Candidate choose(const std::string& what, const std::string& id, const char* option) const {
    return id.empty() ? best(what, option) : named(what, id, option);
  }

  /// Terrain to lie below one that lacks something: the best that has all of the area.
  [[nodiscard]] Candidate below(const Candidate& above) const {
    std::vector<Candidate> candidates;
    for (const CatalogueSource& source : catalogue_.sources) {
      if (source.what != "terrain" || !source.automatic || source.gaps || &source == above.source) continue;
      const double coverage = coverage_of(catalogue_, source, lonlat_);
      if (coverage >= whole) candidates.push_back({&source, coverage});
    }
    if (candidates.empty())
      throw OptionError(
          fmt::format("{} lacks a part of the area, and the catalogue has no terrain of the world to "
                      "lie below it; give your own with --dtm-file",
                      above.source->id));
    return best_of(candidates);
  }

 private:
  [[nodiscard]] Candidate named(const std::string& what, const std::string& id, const char* option) const {
    std::vector<std::string> known;
    for (const CatalogueSource& source : catalogue_.sources) {
      if (source.what != what) continue;
      known.push_back(source.id);
      if (source.id != id) continue;
      const double coverage = coverage_of(catalogue_, source, lonlat_);
      if (coverage == 0.0)
        throw OptionError(fmt::format("{} {}: it lies elsewhere ({}); --list shows what covers the area", option, id,
                                      fmt::join(source.areas, ", ")));
      return {&source, coverage};
    }
    throw OptionError(fmt::format("{} {}: the catalogue has no such source{}", option, id, suggestion(id, known)));
  }

  [[nodiscard]] Candidate best(const std::string& what, const char* option) const {
    std::vector<Candidate> candidates, by_hand;
    for (const CatalogueSource& source : catalogue_.sources) {
      if (source.what != what || (source.most_km2 > 0.0 && area_km2_ > source.most_km2)) continue;
      const double coverage = coverage_of(catalogue_, source, lonlat_);
      if (coverage > 0.0) (source.automatic ? candidates : by_hand).push_back({&source, coverage});
    }
    if (candidates.empty() && by_hand.empty()) refuse(what, option);
    return best_of(candidates.empty() ? by_hand : candidates);
  }

  [[nodiscard]] Candidate best_of(const std::vector<Candidate>& candidates) const {
    const auto better = [this](const Candidate& a, const Candidate& b) {
      // Where none covers all of the area, the one that covers most of it. Outlines reach over the border: what a
      // neighbour seems to cover may not be there.
      const auto rank = [this](const Candidate& c) {
        const double missing = c.coverage < whole ? 1.0 - c.coverage : 0.0;
        const bool at_home = std::ranges::any_of(c.source->areas, [this](const std::string& id) {
          return id == "world" || id.substr(0, id.find('-')) == country_;
        });
        return std::tuple(c.source->surface, missing, !at_home, c.source->resolution_m);
      };
      return rank(a) < rank(b);
    };
    return *std::min_element(candidates.begin(), candidates.end(), better);
  }

  [[noreturn]] void refuse(const std::string& what, const char* option) const {
    std::set<std::string> places;
    for (const CatalogueSource& source : catalogue_.sources)
      if (source.what == what)
        for (const std::string& id : source.areas)
          for (const CatalogueArea& area : catalogue_.areas)
            if (area.id == id) places.insert(area.name);
    const Box2 box = bounds_of(lonlat_.outer);
    throw OptionError(
        fmt::format("no {} of the catalogue can be fetched for {:.5f}, {:.5f} (longitude, latitude){}; there is {} of: "
                    "{}; give your own with {}-file",
                    what, 0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y), swapped_hint(what, box),
                    what == "photo" ? "a photo" : what, fmt::join(places, ", "), option));
  }

  /// People write latitude first.
  [[nodiscard]] std::string swapped_hint(const std::string& what, const Box2& box) const {
    if (std::max(std::abs(box.min_x), std::abs(box.max_x)) > highest_latitude_deg) return "";
    const Polygon swapped{
        {{box.min_y, box.min_x}, {box.max_y, box.min_x}, {box.max_y, box.max_x}, {box.min_y, box.max_x}}, {}};
    for (const CatalogueSource& source : catalogue_.sources)
      if (source.what == what && source.areas != std::vector<std::string>{"world"} &&
          coverage_of(catalogue_, source, swapped) >= whole)
        return fmt::format("; with longitude first it would be --bbox {:.10g},{:.10g},{:.10g},{:.10g}, where {} is",
                           box.min_y, box.min_x, box.max_y, box.max_x, source.id);
    return "";
  }

  const Catalogue& catalogue_;
  const Polygon& lonlat_;
  double area_km2_;
  std::string country_;
};

void check_size(double area_m2) {
  if (area_m2 <= largest_area_m2) return;
  const double parts = std::ceil(area_m2 / largest_area_m2);
  throw OptionError(
      fmt::format("the area has {:.0f} km2, and a site at most {:.0f}; cut it into {:.0f} sites or more "
                  "(a box of 40 x 40 km is 0.36 degrees of latitude high) and build each",
                  area_m2 / 1e6, largest_area_m2 / 1e6, parts));
}

std::string area_text(const Polygon& area, const std::optional<LonLatBox>& box) {
  if (box)
    return fmt::format("bbox_wgs84 = [{:.10g}, {:.10g}, {:.10g}, {:.10g}]  # west, south, east, north\n", (*box)[0],
                       (*box)[1], (*box)[2], (*box)[3]);
  const auto ring_text = [](const Ring& ring) {
    std::string text = "  [", line;
    for (std::size_t i = 0; i <= ring.size(); ++i) {
      const Vec2 p = ring[i % ring.size()];
      line += fmt::format("[{:.7f}, {:.7f}]{}", p.x, p.y, i == ring.size() ? "" : ", ");
      if (line.size() > 90) text += line + "\n   ", line.clear();
    }
    return text + line + "],\n";
  };
  std::string text = "polygon = [  # rings of longitude and latitude, the outer one first\n" + ring_text(area.outer);
  for (const Ring& hole : area.holes) text += ring_text(hole);
  return text + "]\n";
}

/// Fewer corners where there are too many to read: no border needs centimetres.
Polygon readable(const Polygon& area, Findings& findings) {
  Polygon result = area;
  double tolerance_deg = 1e-5;
  for (; result.outer.size() > most_corners; tolerance_deg *= 2.0) {
    const MultiPolygon simpler = simplified({area}, tolerance_deg);
    if (simpler.size() != 1) break;
    result = simpler.front();
  }
  if (result.outer.size() < area.outer.size())
    findings.push_back({Severity::info, "new.simplified",
                        fmt::format("the border had {} corners, the site file has {}: it moved by up to {:.0f} m",
                                    area.outer.size(), result.outer.size(), 0.5 * tolerance_deg * 111e3)});
  return result;
}

struct FetchText {
  std::string to, table, attribution;
};

std::string urls_text(const CatalogueSource& source, const Polygon& lonlat) {
  if (!source.cells) return "url = " + quoted(source.url) + "\n";
  const std::vector<std::string> urls = cell_urls(source, lonlat);
  if (urls.size() == 1 && source.kind != "sheets") return "url = " + quoted(urls.front()) + "\n";
  std::string text = "urls = [\n";
  for (const std::string& url : urls) text += "  " + quoted(url) + ",\n";
  return text + "]\n";
}

FetchText fetch_text(const CatalogueSource& source, const std::string& to, const std::string& subject,
                     const Polygon& lonlat, double finest_m) {
  FetchText text{to, "", fmt::format("{}: {}, {}", subject, source.attribution, source.licence)};
  text.table =
      fmt::format("\n# {} ({}). Checked against: {}.\n", source.name, source.id,
                  source.checked == "memory" ? "memory only; look at the server's capabilities" : source.checked);
  if (!source.note.empty()) text.table += "# " + source.note + "\n";
  text.table += fmt::format("[[fetch]]\nto = {}\nkind = {}\n", quoted(to), quoted(source.kind));
  text.table += urls_text(source, lonlat);
  const std::pair<const char*, const std::string&> texts[] = {{"crs", source.crs},
                                                              {"layer", source.layer},
                                                              {"style", source.style},
                                                              {"format", source.format},
                                                              {"tile_matrix_set", source.tile_matrix_set},
                                                              {"time", source.time},
                                                              {"subdomains", source.subdomains}};
  for (const auto& [key, value] : texts)
    if (!value.empty()) text.table += fmt::format("{} = {}\n", key, quoted(value));
  if (source.resolution_m > 0.0)
    text.table += fmt::format("resolution_m = {:g}\n", std::max(source.resolution_m, finest_m));
  if (source.min_zoom) text.table += fmt::format("min_zoom = {}\n", *source.min_zoom);
  if (source.max_zoom) text.table += fmt::format("max_zoom = {}\n", *source.max_zoom);
  text.table += fmt::format("licence = {}\nattribution = {}\n", quoted(source.licence), quoted(source.attribution));
  if (!source.vertical_datum.empty())
    text.table += fmt::format("vertical_datum = {}\nvertical_unit = {}\n", quoted(source.vertical_datum),
                              quoted(source.vertical_unit));
  return text;
}

/// Where the middle of a box of degrees lies.
std::optional<Country> country_in(const Box2& box) {
  const std::vector<Country> countries = read_countries(catalogue_folder());
  const Country* country = country_at(countries, {0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)});
  return country ? std::optional(*country) : std::nullopt;
}

/// Collects what goes into the sections of the site file.
class SiteWriter {
 public:
  SiteWriter(const Catalogue& catalogue, const NewSiteOptions& options, const SiteFrame& frame)
      : catalogue_(catalogue),
        options_(options),
        frame_(frame),
        country_(country_in(bounds_of(options.area.outer))),
        chooser_(catalogue, options.area, area_m2(frame.area) / 1e6, country_ ? country_->id : "") {}

  void add_photo() {
    if (!options_.photo_files.empty()) return local("photo", options_.photo_files, "Orthophoto");
    std::vector<std::string> ids = options_.photos, files;
    if (ids.empty()) ids.emplace_back();
    for (const std::string& id : ids) {
      if (std::ranges::count(ids, id) > 1) throw OptionError(fmt::format("--photo {}: name each source once", id));
      const Candidate photo = chooser_.choose("photo", id, "--photo");
      const std::string& kind = photo.source->kind;
      const bool tiles = kind == "wmts" || kind == "xyz" || kind == "tms";
      const std::string name = files.empty() ? "photo" : fmt::format("photo_{}", files.size() + 1);
      files.push_back(quoted(add(photo, fmt::format("sources/{}.{}", name, tiles ? "mbtiles" : "tif"), "Orthophoto")));
    }
    sources_ += files.size() == 1 ? "photo = " + files.front() + "\n"
                                  : fmt::format("photo = [{}]  # best first\n", fmt::join(files, ", "));
  }
  void add_osm() {
    if (!options_.osm_file.empty())
      return local("osm", {options_.osm_file}, "Roads: © OpenStreetMap contributors, ODbL");
    const Candidate osm = chooser_.choose("osm", options_.osm, "--osm-source");
    CatalogueSource source = *osm.source;
    if (source.kind == "osm_extract") {
      const CatalogueArea* area = extract_area(catalogue_, options_.area);
      if (!area)
        throw OptionError(
            fmt::format("no extract of {} holds the whole area, as it does at a border; give smaller areas, "
                        "or your own extract with --osm-file",
                        source.id));
      const auto at = source.url.find("{geofabrik}");
      if (at != std::string::npos) source.url.replace(at, std::string_view("{geofabrik}").size(), area->geofabrik);
    }
    const char* to = source.kind == "osm_extract" ? "sources/roads.osm.pbf" : "sources/roads.osm";
    sources_ += "osm = " + quoted(add({&source, osm.coverage}, to, "Roads")) + "\n";
  }
  void add_terrain() {
    if (!options_.dtm_files.empty()) return local("dtm", options_.dtm_files, "Terrain");
    const Candidate best = chooser_.choose("terrain", options_.terrain, "--terrain");
    std::string files = quoted(add(best, "sources/dtm.tif", "Terrain"));
    if (best.coverage < whole || best.source->gaps) {
      const Candidate below = chooser_.below(best);
      const bool of_world = below.source->areas == std::vector<std::string>{"world"};
      files += ", " + quoted(add(below, of_world ? "sources/dtm_world.tif" : "sources/dtm_below.tif", "Terrain"));
    }
    sources_ += "dtm = [" + files + "]  # best first\n";
  }
  [[nodiscard]] NewSite finish(const std::string& area) && {
    std::string attribution;
    for (const std::string& line : attribution_) attribution += "  " + quoted(line) + ",\n";
    const std::string fetch = fetch_.empty() ? "" : "\n# Where the sources come from: `orthodrive fetch` gets them.\n";
    result_.text = fmt::format(
        "# Written by `orthodrive new`. Paths are relative to this file; docs/build.md lists all keys.\nname = {}\n\n"
        "[area]\n{}# CRS: {}, {:.2f} km2\n\n[sources]\n{}\n{}[attribution]\ntext = [\n{}]\n{}{}",
        quoted(options_.name), area, frame_.crs.definition, area_m2(frame_.area) / 1e6, sources_, driving_side(),
        attribution, fetch, fetch_);
    return std::move(result_);
  }
  Findings& findings() { return result_.findings; }

 private:
  /// Where it is not the right, the file says so: whoever reads it need not know the catalogue.
  [[nodiscard]] std::string driving_side() const {
    if (!country_ || country_->driving_side == DrivingSide::right) return {};
    return fmt::format("[refine]\ndriving_side = {}  # {}\n\n", quoted(to_string(country_->driving_side)),
                       country_->name);
  }
  void local(const char* key, const std::vector<std::string>& files, const std::string& subject) {
    std::string names;
    for (const std::string& file : files) names += (names.empty() ? "" : ", ") + quoted(file);
    sources_ += fmt::format("{} = {}{}{}\n", key, files.size() > 1 ? "[" : "", names, files.size() > 1 ? "]" : "");
    attribution_.push_back(subject.find(':') == std::string::npos ? subject + ": name its source and licence here"
                                                                  : subject);
  }
  std::string add(const Candidate& chosen, const std::string& to, const std::string& subject) {
    const CatalogueSource& source = *chosen.source;
    const FetchText text =
        fetch_text(source, to, subject, options_.area, source.what == "photo" ? options_.finest_m : 0.0);
    fetch_ += text.table;
    attribution_.push_back(text.attribution);
    result_.sources.push_back(source.id);
    const Vec2 middle = frame_.area.outer.front();
    if (chosen.coverage < whole)
      result_.findings.push_back(
          {Severity::warning, "new.partly_covered",
           fmt::format("{} covers about {:.0f} % of the area", source.id, 100.0 * chosen.coverage), middle.x,
           middle.y});
    if (!source.automatic)
      result_.findings.push_back({Severity::warning, "new.by_hand",
                                  fmt::format("{} cannot be fetched: {}", source.id, source.note), middle.x, middle.y});
    return text.to;
  }

  const Catalogue& catalogue_;
  const NewSiteOptions& options_;
  const SiteFrame& frame_;
  std::optional<Country> country_;
  Chooser chooser_;
  NewSite result_;
  std::string sources_, fetch_;
  std::vector<std::string> attribution_;
};

}  // namespace

NewSite new_site(const Catalogue& catalogue, const NewSiteOptions& options) {
  const SiteFrame frame = site_frame_of(options.area);
  const double size_m2 = area_m2(frame.area);
  check_size(size_m2);
  SiteWriter writer(catalogue, options, frame);
  writer.findings() = findings_of_area(options.area, frame);
  if (size_m2 > large_area_m2)
    writer.findings().push_back(
        {Severity::info, "new.large_area",
         fmt::format("{:.0f} km2 may need {:.0f} GB of memory to build; smaller sites need less", size_m2 / 1e6,
                     std::ceil(size_m2 * memory_per_m2 / 1e9)),
         frame.area.outer.front().x, frame.area.outer.front().y});
  writer.add_photo();
  writer.add_osm();
  writer.add_terrain();
  const std::string area =
      options.box ? area_text({}, options.box) : area_text(readable(options.area, writer.findings()), std::nullopt);
  return std::move(writer).finish(area);
}

std::string source_table(const Catalogue& catalogue, const Polygon* lonlat) {
  std::string table = fmt::format("{:<17} {:<8} {:>6} {:>6}  {:<13} {:<9} {}\n", "id", "what", "m/px", "area",
                                  "checked", "fetch", "name, licence");
  for (const CatalogueSource& source : catalogue.sources) {
    const double coverage = lonlat ? coverage_of(catalogue, source, *lonlat) : 1.0;
    if (coverage == 0.0) continue;
    const std::string resolution = source.resolution_m > 0.0 ? fmt::format("{:g}", source.resolution_m) : "-";
    const std::string share = lonlat ? fmt::format("{:.0f} %", std::floor(100.0 * coverage))
                                     : fmt::format("{}", fmt::join(source.areas, " ")).substr(0, 6);
    table += fmt::format("{:<17} {:<8} {:>6} {:>6}  {:<13} {:<9} {}, {}\n", source.id, source.what, resolution, share,
                         source.checked, source.automatic ? "automatic" : "by hand", source.name, source.licence);
  }
  return table;
}

}  // namespace orthodrive
