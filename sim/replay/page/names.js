// SPDX-License-Identifier: BSD-3-Clause
// Displayed names: layers with a description, events as text, units of signals.
'use strict';

/** Layers of the page: key, name, hint, and whether they are on at first. */
const kLayers = [
  ['world', 'world', 'Ground, buildings and plants', true],
  ['vehicles', 'vehicles', 'The vehicles at their true poses', true],
  ['names', 'names', 'Names above the vehicles', true],
  ['trails', 'trails', 'Paths that the vehicles have flown', true],
  ['sweeps', 'LiDAR scans', 'Returns of the LiDARs at their true positions', true],
  ['detections', 'detections', 'Flying objects that the detector reports, as boxes', true],
  ['tracks', 'tracks', 'Objects that the tracker follows, with their velocity over one second', true],
  ['covariances', 'track covariances (3σ)', 'Position uncertainty of the tracks, three standard deviations', true],
  ['estimates', 'own pose estimates', 'Where each vehicle estimates itself to be, with a line from its true position', false],
  ['references', 'references', 'Position that each vehicle is asked to fly to now', false],
  ['radio', 'radio links', 'Pairs of vehicles that exchange messages; wider lines carry more messages', false],
  ['events', 'crash marks', 'A cross where a vehicle has crashed', true],
];

/** Overlays of the built-in modules: name and hint. */
const kOverlays = {
  'reference': ['past references', 'Positions that the vehicle was asked to fly to'],
  'waypoints': ['waypoints', 'Waypoints of the mission'],
  'path': ['timed path', 'Path with fixed times'],
  'navigate.path': ['planned path', 'Path through the map to the goal'],
  'explore.path': ['exploration path', 'Path to the next viewpoint'],
  'explore.view': ['next viewpoint', 'Viewpoint that the exploration flies to'],
  'guided_path': ['received path', 'Path that the guided vehicle has received by radio'],
  'guide.primary_path': ['path of the guide', 'Planned path of the guiding vehicle'],
  'guide.secondary_path': ['path of the guided vehicle', 'Path that the guide plans for the guided vehicle'],
  'guide.visible': ['where a waypoint is visible', 'Outline of the area from where a waypoint of the guided vehicle is in line of sight'],
  'guide.overlap': ['where the path is visible', 'Outline of the area from where most of the guided path is in line of sight'],
  'guide.viewpoint': ['viewpoint of the guide', 'Position that the guide has chosen to observe from'],
  'rbl.cell': ['cell', 'Part of the Voronoi cell at flight level in which the vehicle may move'],
  'rbl.cell_outline': ['cell outline', 'Border of the cell at flight level'],
  'rbl.sensing': ['sensing range', 'Range within which neighbors and obstacles shape the cell'],
  'rbl.samples': ['cell samples', 'Points of the cell whose weighted mean is the centroid'],
  'rbl.centroid': ['centroid', 'Weighted centroid of the cell; the vehicle flies toward it'],
  'rbl.sensing_centroid': ['centroid without neighbors', 'Weighted centroid of the whole sensing range'],
  'rbl.destination': ['direction to the destination', 'Direction that weights the cell'],
  'rbl.goal': ['goal', 'Goal of the vehicle'],
  'rbl.voxels': ['obstacle voxels', 'Occupied voxels that bound the cell'],
  'rbl.path': ['detour', 'Path around obstacles that block the direct flight'],
  'intercept.prediction': ['predicted target', 'Predicted motion of the target'],
  'intercept.plan': ['interception plan', 'Planned motion of the interceptor'],
  'intercept.net': ['net', 'Net of the interceptor'],
  'intercept.fence': ['geofence', 'Volume that the interceptor must not leave'],
  'intercept.search': ['search particles', 'Possible positions of a lost target'],
  'voxels.tentative': ['tentative voxels', 'Voxels that the detector considers occupied with low confidence'],
  'voxels.confident': ['confident voxels', 'Voxels that the detector considers occupied with confidence'],
  'voxels.around': ['air around detections', 'Free and uncertain voxels around a detection; free air on all sides makes a flying object'],
  'clusters': ['point clusters', 'Points of the last scan by class: background, flying, unknown'],
  'relative': ['teammate estimates', 'Estimated position and heading of a teammate, three standard deviations'],
  'relative.window': ['teammate sightings', 'Sightings and aligned odometry that the estimate of a teammate is made from'],
  'slam.trajectory': ['SLAM trajectory', 'Trajectory by the pose graph'],
  'slam.submaps': ['SLAM submaps', 'Origins of submaps'],
  'slam.closures': ['loop closures', 'Constraints between submaps'],
  'slam.refused': ['refused loop closures', 'Pairs of submaps that were compared and not joined'],
  'slam.joined': ['joined maps', 'Submaps received from another vehicle, and closures with them'],
  'mapping.cells': ['map near the vehicle', 'Occupied cells of the map around the vehicle'],
  'mapping.map': ['whole map', 'All occupied cells of the map, colored by height'],
  'map.mapping': ['recorded map', 'Copy of the whole map every few seconds'],
  'map.localization': ['map of the localization', 'Copy of the saved map every few seconds'],
};

/** {text, hint} of an overlay. Names of plugins are shown as words, "survey.next_goal" as "survey: next goal", with the legend as hint. */
function describeOverlay(name, meanings) {
  const words = name.replace(/_/g, ' ').replace('.', ': ').replace(/\./g, ' ');
  const [text, about] = Object.hasOwn(kOverlays, name) ? kOverlays[name] : [words, [...meanings].join(', ')];
  return {text, hint: (about ? about + '. ' : '') + `Overlay ${name}`};
}

/** An event in one line, without its time and vehicle. For missions the note suffices. */
function describeEvent({kind, partner, note}) {
  if (kind === 'mission' && note) return note;
  return kind.replace(/_/g, ' ') + (partner ? (kind === 'crash' ? ' into ' : ' ') + partner : '') + (note ? ': ' + note : '');
}

const kUnits = {m: 'm', s: 's', ms: 'ms', mps: 'm/s', mps2: 'm/s²', rad: 'rad', radps: 'rad/s', deg: '°', hz: 'Hz', dB: 'dB', kg: 'kg', bytes: 'B', kBps: 'kB/s'};

/** The unit by the suffix of a column, such as m/s of "speed_mps". */
function unitOf(name) { return kUnits[(name.match(/_([A-Za-z0-9]+)$/) || [])[1]] || ''; }
