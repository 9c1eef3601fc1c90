// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/sim/world/scene.hpp"

/// Materials of the generated worlds. Reflectivities are diffuse, at 865..905 nm; comments give their sources. (R) is
/// RIEGL's table of natural surfaces at 0.9 um: deciduous trees 60 %, conifers 30 %, newspaper 69 %, rough pallet wood
/// 25 %, smooth concrete 24 %, asphalt 17 %.
namespace swiftlet::sim::materials {

inline Material forest_floor() { return {"forest_floor", 0.30F, false, {0.34F, 0.29F, 0.18F}}; }  // litter over soil
inline Material grass() { return {"grass", 0.50F, false, {0.36F, 0.52F, 0.22F}}; }  // red edge: 0.45..0.55 when green
inline Material asphalt() { return {"asphalt", 0.17F, false, {0.27F, 0.27F, 0.28F}}; }  // (R)
inline Material rock() { return {"rock", 0.30F, false, {0.47F, 0.46F, 0.44F}}; }        // granite with lichen
inline Material bark_pine() {
  return {"bark_pine", 0.40F, false, {0.51F, 0.34F, 0.22F}};
}  // bark is 0.35..0.45 in the near infrared
inline Material bark_spruce() { return {"bark_spruce", 0.35F, false, {0.38F, 0.29F, 0.23F}}; }
inline Material bark_broadleaf() { return {"bark_broadleaf", 0.45F, false, {0.47F, 0.45F, 0.41F}}; }  // smooth beech
inline Material dead_wood() { return {"dead_wood", 0.40F, false, {0.44F, 0.37F, 0.29F}}; }
inline Material needles_pine() {
  return {"needles_pine", 0.40F, false, {0.25F, 0.41F, 0.22F}};
}  // (R) 0.3 for a crown with its gaps
inline Material needles_spruce() { return {"needles_spruce", 0.38F, false, {0.15F, 0.32F, 0.18F}}; }
inline Material leaves() {
  return {"leaves", 0.50F, false, {0.38F, 0.55F, 0.20F}};
}  // single leaf 0.45..0.55, crown (R) 0.6
inline Material concrete() {
  return {"concrete", 0.35F, false, {0.62F, 0.61F, 0.59F}};
}  // (R) smooth 0.24, light weathered 0.45
inline Material plaster() {
  return {"plaster", 0.70F, false, {0.87F, 0.84F, 0.77F}};
}  // white masonry (R) 0.85, colored less
inline Material brick() {
  return {"brick", 0.50F, false, {0.62F, 0.33F, 0.25F}};
}  // red brick is bright in the near infrared
inline Material roof_tiles() { return {"roof_tiles", 0.40F, false, {0.58F, 0.28F, 0.20F}}; }    // fired clay, weathered
inline Material metal_sheet() { return {"metal_sheet", 0.45F, false, {0.69F, 0.72F, 0.75F}}; }  // coated sheet
inline Material steel_painted() {
  return {"steel_painted", 0.40F, false, {0.16F, 0.32F, 0.62F}};
}  // paint decides, not the steel
inline Material steel_beam() { return {"steel_beam", 0.45F, false, {0.90F, 0.46F, 0.12F}}; }  // orange paint
inline Material steel_galvanized() {
  return {"steel_galvanized", 0.30F, false, {0.60F, 0.62F, 0.64F}};
}  // mostly specular: weak diffuse returns
inline Material glass() {
  return {"glass", 0.06F, false, {0.42F, 0.55F, 0.63F}};
}  // specular; only dust and frame edges give diffuse returns
inline Material wood_pallet() { return {"wood_pallet", 0.25F, false, {0.72F, 0.57F, 0.37F}}; }  // (R)
inline Material cardboard() { return {"cardboard", 0.60F, false, {0.73F, 0.56F, 0.37F}}; }  // near newspaper (R) 0.69
inline Material wood_painted() { return {"wood_painted", 0.50F, false, {0.40F, 0.26F, 0.16F}}; }
inline Material plastic_dark() { return {"plastic_dark", 0.10F, false, {0.12F, 0.12F, 0.13F}}; }  // carbon-black filled
inline Material car_paint() { return {"car_paint", 0.30F, false, {0.55F, 0.12F, 0.12F}}; }
inline Material clothing() { return {"clothing", 0.40F, false, {0.25F, 0.30F, 0.45F}}; }  // dyes are bright near 0.9 um
inline Material skin() { return {"skin", 0.50F, false, {0.85F, 0.65F, 0.52F}}; }
inline Material retro_tape() {
  return {"retro_tape", 0.90F, true, {0.95F, 0.93F, 0.35F}};
}  // glass beads: retro-reflective

}  // namespace swiftlet::sim::materials
