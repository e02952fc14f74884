// SPDX-License-Identifier: Apache-2.0
#include "roadquery/opendrive/element_table.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace roadquery {
namespace {

constexpr OpenDriveElement element_rows[] = {
    {"CRG", "surface", ElementUse::read, ""},
    {"OpenDRIVE", "", ElementUse::read, ""},
    {"access", "lane", ElementUse::read, ""},
    {"arc", "geometry", ElementUse::read, ""},
    {"border", "lane", ElementUse::read, ""},
    {"borders", "object", ElementUse::passed, ""},
    {"boundary", "junction", ElementUse::passed, ""},
    {"bridge", "objects", ElementUse::read, ""},
    {"center", "laneSection", ElementUse::read, ""},
    {"coefficients", "constant", ElementUse::read, ""},
    {"coefficients", "cubic", ElementUse::read, ""},
    {"coefficients", "linear", ElementUse::read, ""},
    {"coefficients", "quadratic", ElementUse::read, ""},
    {"coefficients", "tOffset", ElementUse::read, ""},
    {"coefficients", "width", ElementUse::read, ""},
    {"connection", "junction", ElementUse::read, ""},
    {"constant", "strip", ElementUse::read, ""},
    {"controller", "OpenDRIVE", ElementUse::passed, ""},
    {"controller", "junction", ElementUse::passed, ""},
    {"cornerLocal", "outline", ElementUse::passed, ""},
    {"cornerRoad", "outline", ElementUse::read, ""},
    {"crossPath", "junction", ElementUse::passed, ""},
    {"crossSectionSurface", "lateralProfile", ElementUse::read, ""},
    {"crossfall", "lateralProfile", ElementUse::read, ""},
    {"cubic", "strip", ElementUse::read, ""},
    {"dataQuality", "*", ElementUse::passed, ""},
    {"defaultRegulations", "header", ElementUse::passed, ""},
    {"elevation", "elevationProfile", ElementUse::read, ""},
    {"elevationGrid", "junction", ElementUse::missed, "the roads' own heights count in the junction"},
    {"elevationProfile", "road", ElementUse::read, ""},
    {"explicit", "roadMark", ElementUse::read, ""},
    {"geoReference", "header", ElementUse::read, ""},
    {"geometry", "planView", ElementUse::read, ""},
    {"header", "OpenDRIVE", ElementUse::read, ""},
    {"height", "lane", ElementUse::read, ""},
    {"include", "*", ElementUse::missed, "what the other file holds is not there; put it into this one"},
    {"junction", "OpenDRIVE", ElementUse::read, ""},
    {"junctionGroup", "OpenDRIVE", ElementUse::passed, ""},
    {"lane", "center", ElementUse::read, ""},
    {"lane", "left", ElementUse::read, ""},
    {"lane", "right", ElementUse::read, ""},
    {"laneLink", "connection", ElementUse::read, ""},
    {"laneOffset", "lanes", ElementUse::read, ""},
    {"laneSection", "lanes", ElementUse::read, ""},
    {"lanes", "road", ElementUse::read, ""},
    {"lateralProfile", "road", ElementUse::read, ""},
    {"left", "laneSection", ElementUse::read, ""},
    {"license", "header", ElementUse::passed, ""},
    {"line", "explicit", ElementUse::read, ""},
    {"line", "geometry", ElementUse::read, ""},
    {"line", "type", ElementUse::read, ""},
    {"linear", "strip", ElementUse::read, ""},
    {"link", "lane", ElementUse::read, ""},
    {"link", "road", ElementUse::read, ""},
    {"markings", "object", ElementUse::passed, ""},
    {"material", "lane", ElementUse::read, ""},
    {"material", "object", ElementUse::passed, ""},
    {"neighbor", "link", ElementUse::passed, ""},
    {"object", "objects", ElementUse::read, ""},
    {"objectReference", "objects", ElementUse::passed, ""},
    {"objects", "junction", ElementUse::passed, ""},
    {"objects", "road", ElementUse::read, ""},
    {"offset", "header", ElementUse::read, ""},
    {"outline", "object", ElementUse::read, ""},
    {"outline", "outlines", ElementUse::read, ""},
    {"outlines", "object", ElementUse::read, ""},
    {"paramPoly3", "geometry", ElementUse::read, ""},
    {"parkingSpace", "object", ElementUse::passed, ""},
    {"planView", "junction", ElementUse::passed, ""},
    {"planView", "road", ElementUse::read, ""},
    {"poly3", "geometry", ElementUse::read, ""},
    {"predecessor", "connection", ElementUse::passed, ""},
    {"predecessor", "link", ElementUse::read, ""},
    {"priority", "junction", ElementUse::read, ""},
    {"quadratic", "strip", ElementUse::read, ""},
    {"railroad", "road", ElementUse::read, ""},
    {"repeat", "object", ElementUse::passed, ""},
    {"restriction", "access", ElementUse::read, ""},
    {"right", "laneSection", ElementUse::read, ""},
    {"road", "OpenDRIVE", ElementUse::read, ""},
    {"roadMark", "lane", ElementUse::read, ""},
    {"roadSection", "junction", ElementUse::passed, ""},
    {"rule", "lane", ElementUse::passed, ""},
    {"shape", "lateralProfile", ElementUse::read, ""},
    {"signal", "signals", ElementUse::passed, ""},
    {"signalGroup", "OpenDRIVE", ElementUse::passed, ""},
    {"signalReference", "signals", ElementUse::passed, ""},
    {"signals", "road", ElementUse::read, ""},
    {"skeleton", "object", ElementUse::passed, ""},
    {"speed", "lane", ElementUse::read, ""},
    {"speed", "type", ElementUse::read, ""},
    {"spiral", "geometry", ElementUse::read, ""},
    {"station", "OpenDRIVE", ElementUse::passed, ""},
    {"strip", "surfaceStrips", ElementUse::read, ""},
    {"successor", "connection", ElementUse::passed, ""},
    {"successor", "link", ElementUse::read, ""},
    {"superelevation", "lateralProfile", ElementUse::read, ""},
    {"surface", "junction", ElementUse::missed, "the OpenCRG file of the junction is not laid on its roads"},
    {"surface", "object", ElementUse::missed, "the OpenCRG file of the object is not laid on the road"},
    {"surface", "road", ElementUse::read, ""},
    {"surfaceStrips", "crossSectionSurface", ElementUse::read, ""},
    {"sway", "roadMark", ElementUse::passed, ""},
    {"switch", "railroad", ElementUse::passed, ""},
    {"tOffset", "crossSectionSurface", ElementUse::read, ""},
    {"tunnel", "objects", ElementUse::read, ""},
    {"type", "road", ElementUse::read, ""},
    {"type", "roadMark", ElementUse::read, ""},
    {"userData", "*", ElementUse::passed, ""},
    {"userData", "junction", ElementUse::read, ""},
    {"userData", "road", ElementUse::read, ""},
    {"validity", "bridge", ElementUse::passed, ""},
    {"validity", "object", ElementUse::passed, ""},
    {"validity", "tunnel", ElementUse::passed, ""},
    {"visibility", "lane", ElementUse::passed, ""},
    {"vmsGroup", "OpenDRIVE", ElementUse::passed, ""},
    {"width", "lane", ElementUse::read, ""},
    {"width", "strip", ElementUse::read, ""},
};

constexpr bool goes_before(const OpenDriveElement& a, const OpenDriveElement& b) {
  return std::pair(a.name, a.parent) < std::pair(b.name, b.parent);
}
static_assert(std::is_sorted(std::begin(element_rows), std::end(element_rows), goes_before));

}  // namespace

std::span<const OpenDriveElement> opendrive_elements() { return element_rows; }

const OpenDriveElement* find_element(std::string_view parent, std::string_view name) {
  for (const std::string_view of : {parent, std::string_view("*")}) {
    const OpenDriveElement* row = std::lower_bound(std::begin(element_rows), std::end(element_rows),
                                                   OpenDriveElement{name, of, ElementUse::read, {}}, goes_before);
    if (row != std::end(element_rows) && row->name == name && row->parent == of) return row;
  }
  return nullptr;
}

}  // namespace roadquery
