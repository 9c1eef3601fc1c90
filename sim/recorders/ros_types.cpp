// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/ros_types.hpp"

#include <stdexcept>
#include <string_view>
#include <vector>

#include "sim/recorders/md5.hpp"

namespace swiftlet::sim {
namespace {

/// Fields and constants of a type in ROS 1 syntax; ros2_text only where it differs.
struct Definition {
  std::string_view name;
  const char* text;
  const char* ros2_text = nullptr;
};

constexpr Definition kDefinitions[] = {
    {"std_msgs/Header", "uint32 seq\ntime stamp\nstring frame_id\n",
     "builtin_interfaces/Time stamp\nstring frame_id\n"},
    {"builtin_interfaces/Time", "", "int32 sec\nuint32 nanosec\n"},
    {"builtin_interfaces/Duration", "", "int32 sec\nuint32 nanosec\n"},
    {"std_msgs/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"},
    {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"},
    {"geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"},
    {"geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n"},
    {"geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"},
    {"geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"},
    {"geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"},
    {"geometry_msgs/Transform", "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"},
    {"geometry_msgs/TransformStamped",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"},
    {"sensor_msgs/PointField",
     "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\n"
     "uint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n"},
    {"sensor_msgs/PointCloud2",
     "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\n"
     "uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n"},
    {"sensor_msgs/Imu",
     "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
     "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
     "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n"},
    {"sensor_msgs/NavSatStatus",
     "int8 STATUS_NO_FIX=-1\nint8 STATUS_FIX=0\nint8 STATUS_SBAS_FIX=1\nint8 STATUS_GBAS_FIX=2\nint8 status\n"
     "uint16 SERVICE_GPS=1\nuint16 SERVICE_GLONASS=2\nuint16 SERVICE_COMPASS=4\nuint16 SERVICE_GALILEO=8\n"
     "uint16 service\n"},
    {"sensor_msgs/NavSatFix",
     "std_msgs/Header header\nsensor_msgs/NavSatStatus status\nfloat64 latitude\nfloat64 longitude\nfloat64 altitude\n"
     "float64[9] position_covariance\nuint8 COVARIANCE_TYPE_UNKNOWN=0\nuint8 COVARIANCE_TYPE_APPROXIMATED=1\n"
     "uint8 COVARIANCE_TYPE_DIAGONAL_KNOWN=2\nuint8 COVARIANCE_TYPE_KNOWN=3\nuint8 position_covariance_type\n"},
    {"nav_msgs/Odometry",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
     "geometry_msgs/TwistWithCovariance twist\n"},
    {"tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"},
    {"sensor_msgs/CompressedImage", "", "std_msgs/Header header\nstring format\nuint8[] data\n"},
    {"visualization_msgs/UVCoordinate", "", "float32 u\nfloat32 v\n"},
    {"visualization_msgs/MeshFile", "", "string filename\nuint8[] data\n"},
    {"visualization_msgs/Marker",
     "uint8 ARROW=0\nuint8 CUBE=1\nuint8 SPHERE=2\nuint8 CYLINDER=3\nuint8 LINE_STRIP=4\nuint8 LINE_LIST=5\n"
     "uint8 CUBE_LIST=6\nuint8 SPHERE_LIST=7\nuint8 POINTS=8\nuint8 TEXT_VIEW_FACING=9\nuint8 MESH_RESOURCE=10\n"
     "uint8 TRIANGLE_LIST=11\nuint8 ADD=0\nuint8 MODIFY=0\nuint8 DELETE=2\nuint8 DELETEALL=3\n"
     "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n"
     "geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nduration lifetime\nbool frame_locked\n"
     "geometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring text\nstring mesh_resource\n"
     "bool mesh_use_embedded_materials\n",
     "int32 ARROW=0\nint32 CUBE=1\nint32 SPHERE=2\nint32 CYLINDER=3\nint32 LINE_STRIP=4\nint32 LINE_LIST=5\n"
     "int32 CUBE_LIST=6\nint32 SPHERE_LIST=7\nint32 POINTS=8\nint32 TEXT_VIEW_FACING=9\nint32 MESH_RESOURCE=10\n"
     "int32 TRIANGLE_LIST=11\nint32 ADD=0\nint32 MODIFY=0\nint32 DELETE=2\nint32 DELETEALL=3\n"
     "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n"
     "geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\n"
     "bool frame_locked\ngeometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring texture_resource\n"
     "sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\nstring text\n"
     "string mesh_resource\nvisualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials\n"},
    {"visualization_msgs/MarkerArray", "visualization_msgs/Marker[] markers\n"},
    {"rosgraph_msgs/Clock", "time clock\n", "builtin_interfaces/Time clock\n"},
};

std::string_view definition_of(std::string_view name, RosDialect dialect) {
  for (const Definition& definition : kDefinitions) {
    if (definition.name != name) continue;
    return dialect == RosDialect::kRos2 && definition.ros2_text ? definition.ros2_text : definition.text;
  }
  throw std::logic_error("no definition of the ROS type " + std::string(name));
}

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  for (std::size_t end; (end = text.find('\n')) != std::string_view::npos; text.remove_prefix(end + 1)) {
    lines.emplace_back(text.substr(0, end));
  }
  return lines;
}

/// The lines of the type itself, without parts.
std::string own_definition(const RosType& type, RosDialect dialect) {
  if (type.text.empty()) return std::string(definition_of(type.package + "/" + type.name, dialect));
  std::string text;
  for (const std::string& line : lines_of(type.text)) {
    const bool is_time = dialect == RosDialect::kRos2 && line.starts_with("time ");
    text += (is_time ? "builtin_interfaces/Time" + line.substr(4) : line) + "\n";
  }
  return text;
}

/// Fingerprint of genmsg: MD5 of the constants, then of the fields, with types of other messages replaced by their
/// fingerprints.
std::string fingerprint(std::string_view definition) {
  std::string constants, fields;
  for (const std::string& line : lines_of(definition)) {
    const std::string type = line.substr(0, line.find(' '));
    const std::string base = type.substr(0, type.find('['));
    if (line.find('=') != std::string::npos) {
      constants += line + "\n";
    } else if (base.find('/') != std::string::npos) {
      fields += fingerprint(definition_of(base, RosDialect::kRos1)) + line.substr(type.size()) + "\n";
    } else {
      fields += line + "\n";
    }
  }
  std::string text = constants + fields;
  if (!text.empty()) text.pop_back();
  return md5(text);
}

constexpr const char* kHeaderType = "std_msgs/Header";
constexpr const char* kTime = "builtin_interfaces/Time";
constexpr const char* kPointCloud2Parts[] = {kHeaderType, kTime, "sensor_msgs/PointField"};
constexpr const char* kImuParts[] = {kHeaderType, kTime, "geometry_msgs/Quaternion", "geometry_msgs/Vector3"};
constexpr const char* kNavSatFixParts[] = {kHeaderType, kTime, "sensor_msgs/NavSatStatus"};
constexpr const char* kOdometryParts[] = {kHeaderType,
                                          kTime,
                                          "geometry_msgs/PoseWithCovariance",
                                          "geometry_msgs/Pose",
                                          "geometry_msgs/Point",
                                          "geometry_msgs/Quaternion",
                                          "geometry_msgs/TwistWithCovariance",
                                          "geometry_msgs/Twist",
                                          "geometry_msgs/Vector3"};
constexpr const char* kPoseStampedParts[] = {kHeaderType, kTime, "geometry_msgs/Pose", "geometry_msgs/Point",
                                             "geometry_msgs/Quaternion"};
constexpr const char* kTFMessageParts[] = {
    "geometry_msgs/TransformStamped", kHeaderType, kTime, "geometry_msgs/Transform", "geometry_msgs/Vector3",
    "geometry_msgs/Quaternion"};
constexpr const char* kClockParts[] = {kTime};
constexpr const char* kMarkerArrayParts[] = {"visualization_msgs/Marker",
                                             kHeaderType,
                                             kTime,
                                             "geometry_msgs/Pose",
                                             "geometry_msgs/Point",
                                             "geometry_msgs/Quaternion",
                                             "geometry_msgs/Vector3",
                                             "std_msgs/ColorRGBA",
                                             "builtin_interfaces/Duration",
                                             "sensor_msgs/CompressedImage",
                                             "visualization_msgs/UVCoordinate",
                                             "visualization_msgs/MeshFile"};

}  // namespace

const RosType kPointCloud2{"sensor_msgs", "PointCloud2", kPointCloud2Parts};
const RosType kImu{"sensor_msgs", "Imu", kImuParts};
const RosType kNavSatFix{"sensor_msgs", "NavSatFix", kNavSatFixParts};
const RosType kOdometry{"nav_msgs", "Odometry", kOdometryParts};
const RosType kPoseStamped{"geometry_msgs", "PoseStamped", kPoseStampedParts};
const RosType kTFMessage{"tf2_msgs", "TFMessage", kTFMessageParts};
const RosType kClock{"rosgraph_msgs", "Clock", kClockParts};
const RosType kMarkerArray{"visualization_msgs", "MarkerArray", kMarkerArrayParts};

std::string full_name(const RosType& type, RosDialect dialect) {
  return type.package + (dialect == RosDialect::kRos2 ? "/msg/" : "/") + type.name;
}

std::string full_definition(const RosType& type, RosDialect dialect) {
  std::string text = own_definition(type, dialect);
  for (const std::string_view part : type.parts) {
    if (dialect == RosDialect::kRos1 && definition_of(part, dialect).empty()) continue;  // built in, or missing
    text += "\n" + std::string(80, '=') + "\nMSG: ";
    text += part;
    text += "\n";
    text += definition_of(part, dialect);
  }
  return text;
}

std::string ros1_fingerprint(const RosType& type) { return fingerprint(own_definition(type, RosDialect::kRos1)); }

}  // namespace swiftlet::sim
