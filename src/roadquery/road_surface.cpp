#include "roadquery/road_surface.hpp"
