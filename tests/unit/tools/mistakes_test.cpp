// What a user types wrong: each mistake ends with an exit code that is not 0 and a message that names what
// was wrong or what would be right.

#include <gmock/gmock.h>

#include <regex>

#include <lcmslam/log/log_writer.hpp>
#include "tests/unit/tools/log_samples.hpp"
#include "tests/unit/tools/scratch.hpp"
#include "tools/commands.hpp"
#include "tools/run_commands.hpp"

namespace lcmslam {
namespace {

struct Mistake {
  const char* name;
  std::vector<std::string>
      words;           ///< after "lcmslam"; "@" stands for the source's folder, the rest is in the scratch
  const char* answer;  ///< a regular expression
};

// In each row what was meant is near: a letter, an order, a unit, a file of another kind.
const Mistake mistakes[] = {
    // the command itself
    {"NoCommand", {}, "usage: lcmslam COMMAND.*batch"},
    {"Command", {"lunch", "robot.yaml"}, "unknown command 'lunch'.*did you mean 'launch'"},
    {"CommandInCapitals", {"BATCH"}, "unknown command 'BATCH'.*did you mean 'batch'"},
    {"Subcommand", {"log", "chek", "run.lcmlog"}, "unknown.*'chek'.*did you mean 'check'"},
    {"MapSubcommand", {"map", "inof", "kitchen.lcmslam"}, "map: unknown.*'inof'.*did you mean 'info'"},
    {"MapOfALog", {"map", "info", "run.lcmlog"}, "run.lcmlog: file is not a database"},
    {"MapThatIsNotThere", {"map", "verify", "kitchn.lcmslam"}, "kitchn.lcmslam: there is no such file"},
    {"PageOfAMapThatIsNotThere",
     {"export", "kitchn.lcmslam", "--html", "page.html"},
     "kitchn.lcmslam: there is no such file"},
    {"QueryOfNothing", {"query"}, "question is required"},
    {"QueryThatIsNone", {"query", "wether"}, "'wether'.*none of distance, collision"},
    {"QueryMember",
     {"query", "distance", "point=1,2,3", "--lcm-url", "memq://"},
     "'points' is missing|'point' is not asked for"},
    {"QueryWithoutEquals", {"query", "planes", "supporting"}, "'supporting' is no NAME=VALUE"},
    {"NoSubcommand", {"log"}, "log.*(info.*check.*repair.*cut.*play)"},
    {"HelpOfNothing", {"help", "bach"}, "unknown command 'bach'.*did you mean 'batch'"},
    {"Option",
     {"batch", "@/config/replay.yaml", "run.lcmlog", "--form", "3"},
     "--form.*(did you mean '?--from|--help)"},

    // launch
    {"LaunchOfNothing", {"launch"}, "config is required"},
    {"LaunchConfiguration", {"launch", "robot.yaml"}, "does not exist: robot.yaml"},
    {"LaunchOfALog", {"launch", "run.lcmlog", "--lcm-url", "memq://"}, "run.lcmlog.*is an LCM log"},
    {"LaunchKey",
     {"launch", "typo.yaml", "--lcm-url", "memq://"},
     "typo.yaml:1: unknown key 'lunch'.*'launch'"},
    {"LaunchProcess",
     {"launch", "process.yaml", "--lcm-url", "memq://"},
     "process.yaml:2: 'processes' must be.*'surf'.*got 'surff'"},

    // batch
    {"BatchWithoutLog", {"batch", "@/config/replay.yaml"}, "log is required"},
    {"BatchConfiguration", {"batch", "replay.yaml", "run.lcmlog"}, "does not exist: replay.yaml"},
    {"BatchOrder",
     {"batch", "run.lcmlog", "@/config/replay.yaml"},
     "run.lcmlog.*is an LCM log.*configuration"},
    {"BatchOfAFolder",
     {"batch", "@/config/replay.yaml", "images"},
     "(is actually a directory|is a folder).*images"},
    {"BatchOfAText", {"batch", "@/config/replay.yaml", "notes.txt"}, "notes.txt: is no LCM log"},
    {"BatchOfNothing", {"batch", "@/config/replay.yaml", "empty.lcmlog"}, "empty.lcmlog: is empty"},
    {"BatchKey",
     {"batch", "@/config/replay.yaml", "run.lcmlog", "--set", "icp.voxel_sise=0.1"},
     "unknown key 'voxel_sise' in 'icp' .did you mean 'voxel_size'"},
    {"BatchValue",
     {"batch", "@/config/replay.yaml", "run.lcmlog", "--set", "icp.voxel_size=small"},
     "'voxel_size' must be a number.*'small'"},
    {"BatchMillimetres",
     {"batch", "@/config/replay.yaml", "run.lcmlog", "--set", "icp.voxel_size=50"},
     "'voxel_size' must be a number.*50"},
    {"BatchChoice",
     {"batch", "@/config/replay.yaml", "run.lcmlog", "--set", "odometry.source=weels"},
     "'source' must be one of.*'wheels'.*'weels'"},
    {"BatchKeyWithoutSection",
     {"batch", "@/config/replay.yaml", "run.lcmlog", "--set", "voxel_size=0.1"},
     "--set voxel_size=0.1: must be section.key=value.*--explain voxel_size"},
    {"BatchSection",
     {"batch", "@/config/replay.yaml", "run.lcmlog", "--set", "ipc.voxel_size=0.1"},
     "unknown key 'ipc'.*did you mean 'icp'"},
    {"BatchSetWithoutValue",
     {"batch", "@/config/replay.yaml", "run.lcmlog", "--set", "icp.voxel_size"},
     "--set icp.voxel_size.*key=value"},
    {"BatchTimes",
     {"batch", "@/config/replay.yaml", "run.lcmlog", "--from", "10", "--to", "5"},
     "--to 5 must be later than --from 10"},
    {"BatchBehindTheEnd",
     {"batch", "@/config/replay.yaml", "run.lcmlog", "--from", "1000"},
     "has no CAMERA .*within the times asked for"},
    {"BatchThreads",
     {"batch", "@/config/replay.yaml", "run.lcmlog", "--threads", "0"},
     "--threads: Value 0 not in range"},
    {"BatchIntoAFile", {"batch", "@/config/replay.yaml", "run.lcmlog", "--out", "notes.txt"}, "notes.txt"},
    {"BatchManyWithoutFolder",
     {"batch", "@/config/replay.yaml", "run.lcmlog", "empty.lcmlog"},
     "several logs need --out"},
    {"BatchLogTwice",
     {"batch", "@/config/replay.yaml", "run.lcmlog", "./run.lcmlog", "--out", "farm"},
     "run.lcmlog: the log is named twice"},
    {"BatchShare",
     {"batch", "@/config/replay.yaml", "run.lcmlog", "--out", "farm", "--share", "4/4"},
     "--share 4/4: must be K/N with K from 0 to N-1"},
    {"BatchExpectations",
     {"batch", "@/config/replay.yaml", "run.lcmlog", "--expect", "notes.txt"},
     "notes.txt"},
    {"BatchListOfNothing",
     {"batch", "@/config/replay.yaml", "--list", "notes.txt", "--out", "farm"},
     "there is no such log"},

    // bridge
    {"BridgeOfNothing", {"bridge"}, "config is required"},
    {"BridgeConfiguration", {"bridge", "operater.yaml"}, "does not exist: operater.yaml"},

    // calibrate
    {"CalibrateNothing", {"calibrate"}, "calibrate.*(board.*camera.*tof.*pair.*mount.*wheels)"},
    {"CalibrateWhat", {"calibrate", "camra", "images"}, "unknown.*'camra'.*did you mean 'camera'"},
    {"CalibrateNowhere", {"calibrate", "camera", "imges"}, "imges"},

    // collect
    {"CollectNowhere", {"collect", "nowhere"}, "does not exist: nowhere"},
    {"CollectNothing", {"collect", "images"}, "images: holds no results .lcmslam batch CONFIG LOG"},

    // import and simulate
    {"ImportOfNothing", {"import", "nowhere", "out.lcmlog"}, "does not exist: nowhere"},
    {"ImportWithoutLog", {"import", "images"}, "log is required"},
    {"ImportOfOtherFiles", {"import", "images", "out.lcmlog"}, "images.*lcmslam.yaml"},
    {"ImportOfALog", {"import", "run.lcmlog", "out.lcmlog"}, "run.lcmlog.*is an LCM log"},
    {"ImportCalibration",
     {"import", "tum", "out.lcmlog", "--calibration", "notes.txt"},
     "notes.txt.*(calibration|mapping|key)"},
    {"ImportDescription",
     {"import", "images", "out.lcmlog", "--description", "typo.yaml"},
     "typo.yaml.*format.*numbered"},
    {"ImportRobot", {"import", "images", "out.lcmlog", "--robot", "7"}, "--robot: Value 7 not in range"},
    {"SimulateScene", {"simulate", "kitchen.yaml", "out.lcmlog"}, "does not exist: kitchen.yaml"},
    {"SimulateHead",
     {"simulate", "@/config/scenes/kitchen.yaml", "out.lcmlog", "--head", "lidar"},
     "head 'lidar' is not known: use tof, rgbd"},
    {"SimulateBase",
     {"simulate", "@/config/scenes/kitchen.yaml", "out.lcmlog", "--base", "tricycle"},
     "base is tricycle.*'differential'"},
    {"SimulateNoScene", {"simulate", "notes.txt", "out.lcmlog"}, "notes.txt"},
    {"SimulateIntoNowhere",
     {"simulate", "@/config/scenes/kitchen.yaml", "nowhere/out.lcmlog", "--seconds", "0.2"},
     "nowhere/out.lcmlog.*(cannot be|No such file)"},

    // evaluate
    {"EvaluateNothing", {"evaluate"}, "no truth: give --truth FILE"},
    {"EvaluateTruth",
     {"evaluate", "--truth", "nowhere.txt", "path.txt"},
     "nowhere.txt.*(not there|cannot be|No such)"},
    {"EvaluateEstimate", {"evaluate", "--truth", "path.txt", "nowhere.txt"}, "nowhere.txt"},
    {"EvaluateText", {"evaluate", "--truth", "path.txt", "notes.txt"}, "notes.txt:1.*"},
    {"EvaluateColumns",
     {"evaluate", "--truth", "path.txt", "short.txt"},
     "short.txt:2.*(8|t x y z qx qy qz qw)"},
    {"EvaluateQuaternion", {"evaluate", "--truth", "path.txt", "degrees.txt"}, "degrees.txt:1.*quaternion"},
    {"EvaluateClocks",
     {"evaluate", "--truth", "path.txt", "later.txt"},
     "5000.000 to 5001.900.*1000.000 to 1001.900.*same clock"},
    {"EvaluateChannel",
     {"evaluate", "--truth", "path.txt", "run.lcmlog:ICP_PSE"},
     "has no channel ICP_PSE.*channels with poses"},
    {"EvaluateImages",
     {"evaluate", "--truth", "path.txt", "run.lcmlog:ENCODERS"},
     "ENCODERS carries no poses"},
    {"EvaluateAlignment",
     {"evaluate", "--truth", "path.txt", "path.txt", "--alignment", "se4"},
     "--alignment.*se3"},
    {"EvaluateMap",
     {"evaluate", "--truth", "path.txt", "path.txt", "--map", "notes.txt"},
     "--map: needs --scene or --reference"},
    {"EvaluatePlot",
     {"evaluate", "--truth", "path.txt", "path.txt", "--plot", "path.pdf"},
     "path.pdf must end in .png or .svg"},
    {"EvaluateFrame",
     {"evaluate", "--truth", "path.txt", "path.txt", "--truth-frame", "base"},
     "--truth-frame.*camera"},

    // log
    {"LogInfo", {"log", "info", "nowhere.lcmlog"}, "nowhere.lcmlog: cannot be opened"},
    {"LogInfoText", {"log", "info", "notes.txt"}, "notes.txt: is no LCM log"},
    {"LogCheckFolder", {"log", "check", "images"}, "images: is a folder"},
    {"LogRepairOntoItself", {"log", "repair", "run.lcmlog", "run.lcmlog"}, "run.lcmlog.*(same|itself|other)"},
    {"LogCutWithoutOut", {"log", "cut", "run.lcmlog"}, "output is required"},
    {"LogCutTimes",
     {"log", "cut", "run.lcmlog", "out.lcmlog", "--from", "20", "--to", "10"},
     "--from.*20.*--to.*10|--to.*10.*--from.*20"},
    {"LogCutBehindTheEnd",
     {"log", "cut", "run.lcmlog", "out.lcmlog", "--from", "1000", "--to", "1010"},
     "run.lcmlog.*(no event|no message|nothing)"},
    {"LogCutChannel",
     {"log", "cut", "run.lcmlog", "out.lcmlog", "--channels", "ODOMETRIE"},
     "ODOMETRIE.*(has|channels)"},
    {"LogCutIntoNowhere", {"log", "cut", "run.lcmlog", "nowhere/out.lcmlog"}, "nowhere/out.lcmlog"},
    {"LogPlayBus",
     {"log", "play", "run.lcmlog", "--lcm-url", "upd://239.255.76.67:7667"},
     "upd://239.255.76.67:7667.*udpm"},
    {"LogPlayAnswer", {"log", "play", "run.lcmlog", "--answer", "ICP_POSE"}, "--answer is for --lockstep"},

    // the bus
    {"SendNothing", {"send"}, "order is required"},
    {"SendWord", {"send", "frobnicate"}, "frobnicate.*save.*smooth.*reset.*stop.*export"},
    {"RenderOfNothing", {"render", "nothing.ply", "out.png"}, "nothing.ply"},
    {"RenderOfText", {"render", "notes.txt", "out.png"}, "notes.txt.*\\.ply or \\.pcd"},
    {"EchoNothing", {"echo"}, "channel is required"},
    {"EchoPattern", {"echo", "(", "--lcm-url", "memq://"}, "'\\('|\\(.*regular expression"},
    {"EchoBus",
     {"echo", "CAMERA", "--lcm-url", "upd://239.255.76.67:7667"},
     "upd://239.255.76.67:7667.*udpm"},
    {"EchoDefinitions",
     {"echo", "CAMERA", "--definitions", "notes.txt", "--lcm-url", "memq://"},
     "notes.txt.*expected 'package' or 'struct'"},
    {"EchoCount", {"echo", "CAMERA", "--count", "-1"}, "--count.*-1"},
    {"SpySeconds", {"spy", "--seconds", "3"}, "--seconds.*--once"},
    {"SpyBus", {"spy", "--once", "--lcm-url", "upd://239.255.76.67:7667"}, "upd://239.255.76.67:7667.*udpm"},
    {"DoctorConfiguration", {"doctor", "robot.yaml"}, "does not exist: robot.yaml"},
    {"DoctorSet", {"doctor", "--set", "icp.voxel_size=0.1"}, "--set.*config"},
    {"DoctorRate", {"doctor", "--rate", "0"}, "--rate: Value 0 not in range"},

    // config, completion
    {"ExplainKey", {"config", "--explain", "voxel_sise"}, "voxel_sise.*voxel_size"},
    {"ListSection", {"config", "--list", "ipc"}, "ipc.*icp"},
    {"CheckIndentation", {"config", "--check", "tabs.yaml"}, "tabs.yaml:2"},
    {"CheckTwice", {"config", "--check", "twice.yaml"}, "twice.yaml:4.*'voxel_size'.*(twice|again)"},
    {"CheckUnit", {"config", "--check", "unit.yaml"}, "unit.yaml:2.*'voxel_size' must be a number.*'5 cm'"},
    {"CheckSetAlone", {"config", "--set", "icp.voxel_size=0.1"}, "--set.*--check"},
    {"ConfigNothing", {"config"}, "--list|--explain|--check"},
    {"Shell", {"completion", "fish"}, "fish.*bash|bash.*fish"},

    // demo, study
    {"DemoData", {"demo", "--data", "nowhere"}, "does not exist: nowhere"},
    {"DemoSeconds", {"demo", "--seconds", "-3"}, "--seconds.*-3"},
    {"DemoWithoutSource", {"demo", "--config", "@/config/robot.yaml"}, "robot.yaml: has no camera.*launch"},
    {"DemoCalibration",
     {"demo", "--calibration", "@/config/calibration/tum_fr1.yaml"},
     "--calibration.*--data"},
    {"StudyName", {"study", "--only", "filters"}, "--only.*filter"},
    {"StudyWithoutLogs", {"study", "--only", "filter"}, "--only filter needs logs"},
    {"StudyWithoutData", {"study", "--only", "pairs"}, "--only pairs needs --data"},
    {"StudySeeds", {"study", "--seeds", "one"}, "--seeds.*one"},
    {"StudyScene",
     {"study", "--only", "filter", "run.lcmlog", "--scene", "bathroom"},
     "bathroom.*(kitchen|not there)"},
};

void PrintTo(const Mistake& mistake, std::ostream* stream) {
  for (const std::string& word : mistake.words) *stream << word << " ";
}

class Typed : public ::testing::TestWithParam<Mistake> {};

std::string tum_path(double start) {
  std::string text;
  for (int i = 0; i < 20; ++i)
    text += std::to_string(start + 0.1 * i) + " " + std::to_string(0.1 * i) + " 0 0 0 0 0 1\n";
  return text;
}

void write_files(const testing::ScratchFolder& folder) {
  folder.write("notes.txt", "what the robot did today\n");
  folder.write("empty.lcmlog", "");
  folder.write("path.txt", tum_path(1000));
  folder.write("later.txt", tum_path(5000));
  folder.write("short.txt", "1000.0 0 0 0 0 0 0 1\n1000.1 0 0 0\n");
  folder.write("degrees.txt", "1000.0 0 0 0 0 0 90 0\n");
  folder.write("typo.yaml", "lunch:\n  processes: [surf]\n");
  folder.write("process.yaml", "launch:\n  processes: [surff, icp]\n");
  folder.write("tabs.yaml", "icp:\n\tvoxel_size: 0.1\n");
  folder.write("twice.yaml", "icp:\n  voxel_size: 0.1\n  range: 5\n  voxel_size: 0.2\n");
  folder.write("unit.yaml", "icp:\n  voxel_size: 5 cm\n");
  std::filesystem::create_directory(folder.path() / "images");
  folder.write("images/holiday.jpg", "x");
  std::filesystem::create_directory(folder.path() / "tum");
  folder.write("tum/rgb.txt", "1000.0 rgb/1000.0.png\n");
  folder.write("tum/depth.txt", "1000.0 depth/1000.0.png\n");
}

/// Runs in the folder, as a shell would; everything that was printed, in one line.
std::string printed_by(const std::vector<std::string>& words, const std::filesystem::path& folder,
                       int& exit_code) {
  std::vector<std::string> line = {"lcmslam"};
  for (const std::string& word : words)
    line.push_back(word.rfind("@/", 0) == 0 ? LCMSLAM_SOURCE_DIR + word.substr(1) : word);
  std::vector<char*> argv;
  for (std::string& word : line) argv.push_back(word.data());
  argv.push_back(nullptr);
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder);
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  exit_code = run_commands(commands(), static_cast<int>(line.size()), argv.data());
  std::string text = ::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr();
  std::filesystem::current_path(before);
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

TEST_P(Typed, IsNamed) {
  const testing::ScratchFolder folder;
  write_files(folder);
  std::filesystem::copy(LCMSLAM_SOURCE_DIR "/logs/office_steered.lcmlog", folder.path() / "run.lcmlog");
  int exit_code = 0;
  const std::string text = printed_by(GetParam().words, folder.path(), exit_code);
  EXPECT_NE(exit_code, 0) << text;
  EXPECT_TRUE(std::regex_search(text, std::regex(GetParam().answer)))
      << "it says:  " << text << "\nexpected: " << GetParam().answer;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "out.lcmlog")) << "a mistake writes nothing";
  EXPECT_EQ(folder.read("notes.txt"), "what the robot did today\n");
  EXPECT_EQ(std::filesystem::file_size(folder.path() / "run.lcmlog"),
            std::filesystem::file_size(LCMSLAM_SOURCE_DIR "/logs/office_steered.lcmlog"));
}

std::string name_of(const ::testing::TestParamInfo<Mistake>& tested) {
  return tested.param.name;
}

INSTANTIATE_TEST_SUITE_P(Mistakes, Typed, ::testing::ValuesIn(mistakes), name_of);

TEST(Mistakes, AreManyAndOverAllCommands) {
  EXPECT_GE(std::size(mistakes), 60U);
  for (const Command& command : commands()) {
    if (std::string(command.name) == "lcm-spy") continue;  // its parts are asked in lcm_spy_test.cpp
    EXPECT_TRUE(std::any_of(std::begin(mistakes), std::end(mistakes), [&](const Mistake& mistake) {
      return !mistake.words.empty() && mistake.words.front() == command.name;
    })) << command.name;
  }
}

}  // namespace
}  // namespace lcmslam
