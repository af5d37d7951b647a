#pragma once
// The tables of a map file, and how files of older versions get today's.
//
//   run          each process that wrote: version and configuration
//   session      what one mapper made under one frame; where that lies in the map, once it is known
//   calibration  of each sensor, as it was last said
//   keyframe     nodes of the graph: pose and its covariance
//   cloud        of keyframes, points coloured, camera frame
//   features     of keyframes, descriptors with their points
//   images       of keyframes, colour and depth as they travelled
//   camera       calibrations by which images were taken, each once
//   edge         of the graph
//   landmark     with covariance and descriptor
//   trajectory   of the mapper, some poses a row
//
// A version is never changed once it was released: what changes is a new one at the end of the list.

#include <lcmslam/map_store/file/sqlite.hpp>

namespace lcmslam {

/// Of files that are written today.
extern const int newest_schema;

/// Behind WHERE: the last row of a table of calibrations that is of the sensor which is the parameter. Its
/// name there may say more behind a semicolon (to_message() of RgbdCalibration).
extern const char* const is_of_sensor;

/// The schema's version of a map file; 0 for one without any table, as a process leaves it that was killed
/// when it had just begun. Throws StoreError for a file that is none, and for one of a newer version than
/// this program knows.
int schema_of(Database& database);

/// Brings an empty or older file to today's schema; all of it or nothing. Throws as schema_of().
void migrate(Database& database);

}  // namespace lcmslam
