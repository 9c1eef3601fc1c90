// SPDX-License-Identifier: BSD-3-Clause
#include "sim/python/maps.hpp"

#include <pybind11/stl.h>

#include "sim/python/fields.hpp"

namespace swiftlet::python {

py::dict maps_of(const Agent& agent) {
  auto copies = std::make_shared<std::vector<MapVoxels>>();
  {
    const py::gil_scoped_release parallel;
    agent.append_maps(*copies);
  }
  py::dict maps;
  for (const MapVoxels& map : *copies) {
    const auto count = static_cast<py::ssize_t>(map.size());
    py::dict one;
    one["edge_m"] = map.edge_m;
    one["states"] = map.states;
    one["occupied_from"] = static_cast<int>(map.occupied_from);
    one["centers_local_m"] = view_of(reinterpret_cast<const float*>(map.centers_local_m.data()), {count, 3}, copies);
    one["state"] = view_of(map.state.data(), {count}, copies);
    one["value"] = view_of(map.value.data(), {count}, copies);
    maps[py::str(map.name)] = one;
  }
  return maps;
}

}  // namespace swiftlet::python
