#include "core/run_files/run_output.h"

#include <sys/prctl.h>
#include <sys/wait.h>

#include <csignal>
#include <regex>

#include "core/motion/sample_area.h"
#include "core/run_files/observable_output.h"
#include "tests/support/markup_defect.h"
#include "tests/support/scene_run.h"
#include "tests/support/scene_text.h"
#include "tests/support/source_folder.h"

namespace bipot {
namespace {

/// Three disks and three walls with awkward numbers in every field.
Scene<2> awkward_scene() {
  Scene<2> scene{.title = "a <\"title\"> & such",
                 .source = "generated",
                 .gravity = Vec2(0.1, -9.81),
                 .materials = {"steel", "glass"},
                 .laws = {{0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}, {0.4, 0.5, 0.6}, {0.7, 0.8, 0.9}},
                 .step = 1e-3,
                 .num_steps = 10};
  scene.output.ledger_every = 2;
  scene.output.track = {2, 0};
  scene.solver.parameters = {{"omega", "1.5"}};
  for (int k = 0; k < 3; ++k) {
    scene.bodies.push_back({.x = Vec2(k / 3.0, -0.0),
                            .angle = 1e-310 * k,
                            .v = Vec2(-0.0, k / 7.0),
                            .spin = -k / 9.0,
                            .radius = 0.1 + k / 11.0,
                            .mass = 1 + k / 13.0,
                            .inertia = 0.1 + k / 17.0,
                            .material = k % 2});
  }
  Wall<2> floor;
  floor.name = "floor";
  floor.a = Vec2(0.0, -1.0 / 3);
  Wall<2> lid;
  lid.name = "lid";
  lid.shape = Wall<2>::Shape::kSegment;
  drive(lid, Vec2(0, -1), 2.0 / 3, 5.0 / 3);
  lid.a = Vec2(-1, 1.0 / 3);
  lid.b = Vec2(2, 1.0 / 3);
  lid.v = Vec2(0, -1.0 / 7);
  lid.material = 1;
  Wall<2> side{.name = "",
               .motion = Wall<2>::Motion::kMoving,
               .a = Vec2(-1.5, 0),
               .normal = Vec2(0.6, 0.8),
               .v = Vec2(1.0 / 3, 0)};
  scene.walls = {floor, lid, side};
  return scene;
}

State<2> awkward_state(const Scene<2>& scene, int step) {
  State<2> state = initial_state(scene);
  state.step = step;
  state.time = step * scene.step;
  state.wall_work = 1.0 / 3;
  state.friction_loss = -0.0;
  state.shock_loss = 2.0 / 7;
  for (int k = 0; k < 2; ++k) {
    ContactOutcome<2> c{
        .contact = {.i = k, .j = k == 0 ? 1 : 3, .n = Vec2(-0.6, 0.8), .gap = -1e-17 * k},
        .s_n = k / 3.0,
        .s_t = -k / 30.0,
        .u_n = 1e-5 / 3,
        .u_t = -0.0,
        .status = k == 0 ? ContactStatus::kTakeOff : ContactStatus::kSlip};
    state.contacts.push_back(c);
  }
  return state;
}

std::vector<std::vector<std::string>> csv(const fs::path& path) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    rows.emplace_back();
    std::stringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

/// All files below a folder by name.
std::map<std::string, std::string> files_in(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    files[fs::relative(entry.path(), folder).string()] = file_text(entry.path());
  }
  return files;
}

StepReport<2> report_of(const State<2>& state) {
  StepReport<2> report{.step = state.step, .time = state.time, .iterations = 7};
  report.energy.kinetic = 1.0 / 3;
  report.penetration = 1e-7 / 3;
  return report;
}

/// Runs of the awkward scene in a folder of their own.
class RunOutput : public testing::Test {
 protected:
  /// Writes frames of these states, and rows of them on demand, after a step of an earlier run.
  void write(const std::vector<State<2>>& states, bool rows = false, int resume_after = -1) {
    RunWriter<2> writer(out_, scene_, "", resume_after);
    for (const State<2>& state : states) {
      if (rows) writer.step(state, report_of(state));
      writer.frame(state);
    }
  }
  State<2> at(int step) const { return awkward_state(scene_, step); }
  Hdf5File opened(const std::string& name) const { return {out_ / name, Hdf5File::Mode::kRead}; }
  std::string index() const { return file_text(out_ / "run.xdmf"); }

  const TemporaryFolder folder_;
  const fs::path out_ = folder_ / "out";
  Scene<2> scene_ = awkward_scene();
};
using ThreadedRunOutput = RunOutput;

TEST_F(RunOutput, AStateIsReadBackBitForBit) {
  const State<2> first = initial_state(scene_);
  const State<2> last = at(8);
  {
    RunWriter<2> writer(out_, scene_, "the scene's text");
    writer.frame(first);
    writer.frame(last);
    writer.close();
  }
  EXPECT_EQ(steps_in_folder(out_), (std::vector<int>{0, 8}));
  EXPECT_EQ(bits_of_state(read_state(out_)), bits_of_state(last));
  EXPECT_EQ(bits_of_state(read_state(out_ / "run.h5", 8)), bits_of_state(last));
  EXPECT_EQ(bits_of_state(read_state(out_, 0)), bits_of_state(first));
  EXPECT_EQ(opened("run.h5").read_string("/scene"), "the scene's text");
  EXPECT_THROW(read_state(out_, 3), FileError);
  EXPECT_THROW(read_state(folder_ / "nothing"), FileError);
  EXPECT_THROW(read_state(folder_ / "nothing/run.h5"), FileError);
  EXPECT_THROW(read_state(out_ / "frames/00000000.h5"), FileError);  // not a run
}

// Run.h5 keeps the values of the scene.
TEST_F(RunOutput, WallsWithAScheduleHaveTheForceSpinAndBeltOfTheFrame) {
  scene_.walls[1].starts = 0.5;
  scene_.walls[2].belt = Vec2(0.8, -0.6) / 3;
  scene_.walls.push_back({.name = "wheel",
                          .shape = Wall<2>::Shape::kSolidCircle,
                          .motion = Wall<2>::Motion::kMoving,
                          .a = Vec2(0, 5),
                          .radius = 1,
                          .spin = 2});
  State<2> state = at(2);
  state.walls[1].force = 7.0 / 3;
  state.walls[2].belt.setZero();
  state.walls[3].spin = 6;
  write({state});
  const State<2> read = read_state(out_);
  EXPECT_EQ(read.walls[1].force, 7.0 / 3);
  EXPECT_EQ(read.walls[2].belt, Vec2(0, 0));
  EXPECT_EQ(read.walls[3].spin, 6);
  const Hdf5File fixed = opened("run.h5");
  EXPECT_EQ(fixed.read_doubles("/walls/force")[1], 5.0 / 3);
  EXPECT_EQ(fixed.read_doubles("/walls/spin")[3], 2);
  EXPECT_EQ(fixed.read_doubles("/walls/belt")[4], 0.8 / 3);
}

TEST_F(RunOutput, EveryFrameCanBeReadThroughTheLinksOfTheRunFile) {
  write({at(1), at(2)});
  fs::rename(out_, folder_ / "moved");  // links are relative
  const Hdf5File file(folder_ / "moved/run.h5", Hdf5File::Mode::kRead);
  EXPECT_EQ(file.list("/frames"), (std::vector<std::string>{"00000001", "00000002"}));
  EXPECT_EQ(file.read_int("/frames/00000002/step"), 2);
  EXPECT_EQ(file.shape("/frames/00000002/bodies/v"), (std::vector<std::size_t>{3, 3}));
  // Force = impulse / time step.
  EXPECT_EQ(file.read_doubles("/frames/00000002/contacts/force_n")[1], (1 / 3.0) / 1e-3);
  // Disk 1 touches the floor (body 3): the segment ends at x - a n.
  const std::vector<double> segment = file.read_doubles("/frames/00000002/contacts/segment");
  ASSERT_EQ(segment.size(), 8u);
  const Disk& d = scene_.bodies[1];
  EXPECT_EQ(Vec2(segment[4], segment[5]), d.x);
  EXPECT_EQ(Vec2(segment[6], segment[7]), Vec2(d.x - d.radius * Vec2(-0.6, 0.8)));
  EXPECT_EQ(Vec2(segment[2], segment[3]), scene_.bodies[1].x);  // the first joins disks 0 and 1
  EXPECT_EQ(file.read_string("/solver/parameters/omega"), "1.5");
  EXPECT_EQ(file.shape("/materials/mu"), (std::vector<std::size_t>{2, 2}));
}

/// Every data item leads to a dataset of the shape it says.
int expect_data(const fs::path& folder, const std::string& xml) {
  const std::regex item("Dimensions=\"([0-9 ]+)\" NumberType=\"(\\w+)\"[^>]*>([^:<]+):([^<]+)<");
  int count = 0;
  for (std::sregex_iterator it(xml.begin(), xml.end(), item), end; it != end; ++it, ++count) {
    const Hdf5File file(folder / (*it)[3].str(), Hdf5File::Mode::kRead);
    std::stringstream extents((*it)[1].str());
    std::size_t product = 1;
    std::vector<std::size_t> shape;
    for (std::size_t extent; extents >> extent; product *= extent) shape.push_back(extent);
    EXPECT_EQ(file.shape((*it)[4]), shape) << (*it)[4];
    EXPECT_EQ(file.size((*it)[4]), product) << (*it)[4];
    EXPECT_EQ(
        (*it)[2] == "Int" ? file.read_ints((*it)[4]).size() : file.read_doubles((*it)[4]).size(),
        product);
  }
  return count;
}

TEST_F(RunOutput, TheXdmfIndexIsWellFormedAndLeadsToItsDataAfterEveryFrame) {
  RunWriter<2> writer(out_, scene_, "");
  for (int step = 0; step < 4; ++step) {
    State<2> state = at(step);
    if (step == 0) state.contacts.clear();
    writer.frame(state);
    const std::string xml = index();
    EXPECT_EQ(markup_defect(xml), "");
    EXPECT_FALSE(std::regex_search(xml, std::regex("Center=\"(?!Node|Cell)")));  // ParaView's words
    // Disks: points, x, radius, mass, material, v, spin, angle, stress, pressure. Contacts: points,
    // segment and ten fields, with or without contacts. Walls: points, segment, material.
    EXPECT_EQ(expect_data(out_, xml), (step + 1) * (10 + 12 + 3));
    for (const char* name : {"bodies", "contacts", "walls"}) {
      EXPECT_TRUE(says(xml, fmt::format("<Grid Name=\"{}\" GridType=\"Collection\" "
                                        "CollectionType=\"Temporal\">",
                                        name)));
    }
  }
}

TEST_F(RunOutput, TheIndexSaysWhichClusterADiskIsPartOf) {
  const std::string text =
      "clusters = [{parts = [[0, 0, 0.1], [0.15, 0, 0.1]], position = [0, 1], mass = 1}]\n"
      "disks = [{position = [2, 1], radius = 0.1, mass = 1}]\n"
      "outlets = [{point = [0, 0], normal = [0, 1]}]\n"
      "time = {step = 0.1, steps = 2}\n";
  const Scene<2> scene = scene_of(text);
  RunWriter<2> writer(out_, scene, text);
  State<2> state = initial_state(scene);
  writer.frame(state);
  EXPECT_EQ(opened("frames/00000000.h5").read_ints("/bodies/cluster"),
            (std::vector<int>{-1, 0, 0}));
  // All have left: what stands in for them is part of none.
  state.step = 1;
  state.bodies.clear();
  state.clusters = {};
  state.population.numbers.clear();
  writer.frame(state);
  writer.close();
  const std::string xml = index();
  EXPECT_EQ(markup_defect(xml), "");
  // Disks: points, x, radius, mass, material, cluster, v, spin, angle, stress, pressure; contacts:
  // twelve.
  EXPECT_EQ(expect_data(out_, xml), 2 * (11 + 12));
  EXPECT_TRUE(says(xml, "Attribute Name=\"cluster\""));
}

TEST_F(RunOutput, ALongRunIsIndexedCompletely) {
  scene_.walls.clear();
  RunWriter<2> writer(out_, scene_, "");
  State<2> state = initial_state(scene_);
  for (state.step = 0; state.step < 150; ++state.step) writer.frame(state);
  writer.close();
  EXPECT_EQ(expect_data(out_, index()), 150 * 22);
  EXPECT_EQ(opened("run.h5").list("/frames").size(), 150u);
}

TEST_F(RunOutput, TheCsvFilesHaveOneValueForEachColumn) {
  RunWriter<2> writer(out_, scene_, "");  // every second step, disks 2 and 0
  for (int step = 1; step <= 5; ++step) {
    const State<2> state = at(step);
    writer.step(state, report_of(state));
  }
  EXPECT_EQ(csv(out_ / "ledger.csv").size(), 3u);
  writer.finish(at(5));  // the last step is always written
  const auto ledger = csv(out_ / "ledger.csv");
  ASSERT_EQ(ledger.size(), 4u);
  EXPECT_EQ(ledger[1][0], "2");
  EXPECT_EQ(ledger[2][0], "4");
  EXPECT_EQ(ledger[3][0], "5");
  for (const auto& row : ledger) EXPECT_EQ(row.size(), 28u);
  const auto first = [&](const std::string& name) {
    const auto at = std::find(ledger[0].begin(), ledger[0].end(), name);
    return at == ledger[0].end() ? "no column " + name : ledger[1][to_size(at - ledger[0].begin())];
  };
  EXPECT_EQ(first("iterations"), "7");
  EXPECT_EQ(first("converged"), "1");
  EXPECT_EQ(std::stod(first("kinetic")), 0.333333333);  // 9 digits
  EXPECT_NEAR(std::stod(first("penetration")), 1e-7 / 3, 1e-16);
  EXPECT_EQ(first("raw42"), "nan");

  const auto trajectory = csv(out_ / "trajectory.csv");
  ASSERT_EQ(trajectory.size(), 11u);
  for (const auto& row : trajectory) EXPECT_EQ(row.size(), 9u);
  EXPECT_EQ(trajectory[1][2], "2");
  EXPECT_EQ(trajectory[2][2], "0");
  EXPECT_NEAR(std::stod(trajectory[1][3]), scene_.bodies[2].x[0], 1e-8);
  EXPECT_NEAR(std::stod(trajectory[1][8]), scene_.bodies[2].spin, 1e-8);
}

TEST_F(RunOutput, EachNumberOfTheBalancesHasItsColumn) {
  scene_.model = Model::kSpringDashpot;
  scene_.laws[0].cohesion = 1;
  scene_.outlets.emplace_back();
  State<2> state = at(2);
  state.population.outlets = {{.momentum = Vec2(-10, -11)}};
  StepReport<2> report = report_of(state);
  report.energy = {.kinetic = 1,
                   .potential = 2,
                   .wall_work = 3,
                   .friction_loss = 4,
                   .shock_loss = 5,
                   .imbalance = 6,
                   .elastic = 7,
                   .cohesion_loss = 8,
                   .passed = 9};
  report.momentum = Vec2(12, 13);
  report.momentum_imbalance = Vec2(14, 15);
  RunWriter<2>(out_, scene_, "").step(state, report);
  const NumberTable ledger = read_number_table(out_ / "ledger.csv");
  double expected = 1;
  for (const char* name :
       {"kinetic", "potential", "wall_work", "friction_loss", "shock_loss", "imbalance", "elastic",
        "cohesion_loss", "passed", "momentum_passed_x", "momentum_passed_y", "momentum_x",
        "momentum_y", "momentum_imbalance_x", "momentum_imbalance_y"}) {
    EXPECT_EQ(ledger.rows.at(0)[ledger.column(name)], expected++) << name;
  }
}

/// Rows that are left out change neither the others nor the frames.
TEST_F(RunOutput, RowsThatAreNotDueChangeNothingElse) {
  const auto state_at = [&](int step) {
    State<2> state = at(step);
    state.bodies[0].v[0] += step;  // and another stress
    return state;
  };
  for (const int every : {1, 3, 100}) {
    scene_.output.ledger_every = every;
    RunWriter<2> writer(folder_ / std::to_string(every), scene_, "");
    for (int step = 1; step <= 8; ++step) {
      const State<2> state = state_at(step);
      writer.step(state, report_of(state));
      if (step % 4 == 0 || step == 6) writer.frame_beside(state);
    }
    writer.finish(state_at(8));
  }
  const auto all = csv(folder_ / "1/ledger.csv");
  ASSERT_EQ(all.size(), 9u);
  const auto third = csv(folder_ / "3/ledger.csv"), last = csv(folder_ / "100/ledger.csv");
  ASSERT_EQ(third.size(), 4u);
  EXPECT_EQ(third[1], all[3]);
  EXPECT_EQ(third[2], all[6]);
  EXPECT_EQ(third[3], all[8]);
  ASSERT_EQ(last.size(), 2u);
  EXPECT_EQ(last[1], all[8]);
  EXPECT_TRUE(files_in(folder_ / "1/frames") == files_in(folder_ / "3/frames"));
  EXPECT_TRUE(files_in(folder_ / "1/frames") == files_in(folder_ / "100/frames"));
}

TEST_F(RunOutput, FramesAndLedgerHoldTheStresses) {
  const State<2> state = at(2);
  write({state}, true);
  const auto moments = contact_moments(state);
  const auto disks = disk_stresses(state, scene_.step, moments);
  const double area = sample_measure(state, scene_.step);
  const MeanStress<2> sample = sample_stress(state, scene_.step, area, moments);
  const Hdf5File file = opened("frames/00000002.h5");
  ASSERT_EQ(file.shape("/bodies/stress"), (std::vector<std::size_t>{3, 6}));
  const auto stress = file.read_doubles("/bodies/stress"),
             p = file.read_doubles("/bodies/pressure");
  for (std::size_t k = 0; k < 3; ++k) {
    const Mat2 total = disks[k].total();
    EXPECT_EQ(stress[6 * k], total(0, 0));
    EXPECT_DOUBLE_EQ(stress[6 * k + 1], total(1, 0));
    EXPECT_EQ(stress[6 * k + 3], total(1, 1));
    EXPECT_EQ(p[k], disks[k].pressure());
    for (int zero : {2, 4, 5}) EXPECT_EQ(stress[6 * k + static_cast<std::size_t>(zero)], 0);
  }
  EXPECT_GT(p[1], 0);
  EXPECT_EQ(file.read_double("/sample/area"), area);
  const auto contact = file.read_doubles("/sample/contact_stress");
  EXPECT_EQ(contact[1], sample.contact(0, 1));
  EXPECT_EQ(contact[2], sample.contact(1, 0));
  EXPECT_EQ(file.read_doubles("/sample/kinetic_stress")[0], sample.kinetic(0, 0));
  EXPECT_EQ(file.read_doubles("/sample/spin_stress")[1], sample.spin(0, 1));
  const auto ledger = csv(out_ / "ledger.csv");
  EXPECT_EQ(ledger[0][23], "area");
  EXPECT_NEAR(std::stod(ledger[1][23]), area, 1e-8 * area);
  const double size = 1e-8 * sample.total().norm();
  EXPECT_NEAR(std::stod(ledger[1][24]), sample.total()(0, 0), size);
  EXPECT_NEAR(std::stod(ledger[1][25]), sample.total()(1, 1), size);
  EXPECT_NEAR(std::stod(ledger[1][26]), sample.total()(0, 1), size);
  EXPECT_NEAR(std::stod(ledger[1][27]), 0.5 * sample.kinetic.trace(), size);
}

// Each number with a unit says what it is, and the codes and indices of contacts have their rules.
TEST_F(RunOutput, EachDatasetWithAUnitIsDescribed) {
  write({at(2)});
  int described = 0;
  for (const char* name : {"run.h5", "frames/00000002.h5"}) {
    const Hdf5File file(out_ / name, Hdf5File::Mode::kRead);
    for (const std::string& group : file.list("/")) {
      if (group == "frames" || group == "solver") continue;
      std::vector<std::string> entries{"/" + group};
      if (group == "bodies" || group == "walls" || group == "contacts" || group == "sample") {
        entries.clear();
        for (const std::string& entry : file.list("/" + group)) {
          entries.push_back("/" + group + "/" + entry);
        }
      }
      for (const std::string& entry : entries) {
        if (!file.has_attribute(entry, "unit")) continue;
        EXPECT_TRUE(file.has_attribute(entry, "description")) << name << " " << entry;
        ++described;
      }
    }
    for (const char* rule : {"/contacts/i", "/contacts/j", "/contacts/status"}) {
      EXPECT_EQ(file.has_attribute(rule, "description"), file.exists(rule)) << rule;
    }
  }
  EXPECT_GT(described, 25);
}

// A disk of 2 kg rests on the floor with 20 N, and a lid presses it with 3 N that a contact at its
// top carries. The point of a contact is the centre less the radius times the normal.
TEST_F(RunOutput, WallsHaveTheirLoadsAndContactsTheirVectors) {
  scene_ = one_law<2>({.mu = 0.5});
  scene_.step = 0.1;
  scene_.bodies = {round_body<2>(Vec2(3, 1), 1, 2)};
  scene_.walls = {half_space<2>(Vec2::Zero(), Vec2::UnitY(), "floor, left"),
                  half_space<2>(Vec2(0, 2), -Vec2::UnitY(), "lid")};
  drive(scene_.walls[1], -Vec2::UnitY(), 1, 3);
  State<2> state = initial_state(scene_);
  state.step = 1;
  state.time = 0.1;
  state.contacts = {{.contact = {.i = 0, .j = 1, .n = Vec2::UnitY()}, .s_n = 2.3, .s_t = 0.5},
                    {.contact = {.i = 0, .j = 2, .n = -Vec2::UnitY()}, .s_n = 0.3}};
  write({state}, true);
  // t = n turned by +90 degrees is -x at the floor.
  EXPECT_EQ(file_text(out_ / "walls.csv"),
            "step,time,wall,x,y,vx,vy,force_x,force_y,reaction_x,reaction_y\n"
            "1,0.1,\"floor, left\",0,0,0,0,nan,nan,5,-23\n1,0.1,lid,0,2,0,0,0,-3,0,3\n");
  const std::string units = file_text(out_ / "units.csv");
  EXPECT_EQ(units.rfind("file,column,unit\nledger.csv,time,s\n", 0), 0u);
  EXPECT_TRUE(says(units, "\nwalls.csv,reaction_y,N\n"));
  const Hdf5File frame = opened("frames/00000001.h5");
  EXPECT_EQ(frame.read_doubles("/contacts/point"), (std::vector<double>{3, 0, 3, 2}));
  const auto force = frame.read_doubles("/contacts/force");
  ASSERT_EQ(force.size(), 4u);
  EXPECT_DOUBLE_EQ(force[0], -5);
  EXPECT_DOUBLE_EQ(force[1], 23);
  EXPECT_DOUBLE_EQ(force[3], -3);
}

TEST(CsvFile, EarlierRowsUnderOtherColumnsAreNotLost) {
  const TemporaryFolder folder;
  const auto path = folder / "rows.csv";
  { CsvFile(path, "step,a,b", -1).row("1,2,3"); }
  EXPECT_THROW(CsvFile(path, "step,a,c", 1), FileError);
  EXPECT_EQ(csv(path).size(), 2u);
  { CsvFile(path, "step,a,b,c", 1).row("2,4,5,6"); }
  EXPECT_EQ(csv(path)[1].back(), "nan");
  { CsvFile other(path, "step,d", 0); }  // goes on before the first row
  EXPECT_EQ(csv(path).size(), 1u);
}

TEST(CsvFile, RowsThatWereCutOffAreTold) {
  const TemporaryFolder folder;
  const auto path = folder / "rows.csv";
  const std::string whole = "step,name,a\n1,\"left, low\",3\n";
  std::ofstream(path) << whole << "2,right\n";
  EXPECT_TRUE(
      says(refusal_of<FileError>([&] { CsvFile(path, "step,name,a", 2); }), "row of step 2"));
  EXPECT_EQ(file_text(path), whole + "2,right\n");
  // Torn in its last number, it has all commas; torn in its step, it is a later row.
  std::ofstream(path) << whole << "2,right,3.1";
  EXPECT_TRUE(
      says(refusal_of<FileError>([&] { CsvFile(path, "step,name,a", 2); }), "row of step 2"));
  std::ofstream(path) << whole << "1";
  { CsvFile before(path, "step,name,a", 1); }
  EXPECT_EQ(file_text(path), whole);
}

TEST(CsvFile, NumbersHaveNineDigitsAndNoSignOfNan) {
  std::string line;
  for (const double x : {0.1, 1.0 / 3, -kNaN, 12345678901.0}) add_number(line, x);
  EXPECT_EQ(line, ",0.1,0.333333333,nan,1.23456789e+10");
}

// Files of version 1 have /disks; a run goes on from them.
TEST_F(RunOutput, ARunWithTheOldNameOfTheBodiesIsContinued) {
  const State<2> state = at(2);
  write({state});
  for (const char* name : {"run.h5", "frames/00000002.h5"}) {
    Hdf5File file(out_ / name, Hdf5File::Mode::kAppend);
    file.rename("/bodies", "/disks");
    if (file.exists("/format_version")) file.write("/format_version", 1);
  }
  EXPECT_EQ(bits_of_state(read_state(out_)), bits_of_state(state));
  write({at(4)}, false, 2);
  EXPECT_EQ(bits_of_state(read_state(out_, 2)), bits_of_state(state));
  expect_data(out_, index());
}

TEST_F(RunOutput, ARunOfAVersionWithoutStressesIsContinued) {
  const State<2> first = at(2), second = at(4);
  write({first}, true);
  // As it was written before: no stresses in the frame, fewer columns in the ledger.
  {
    Hdf5File frame(out_ / "frames/00000002.h5", Hdf5File::Mode::kAppend);
    for (const char* name : {"/bodies/stress", "/bodies/pressure", "/sample"}) frame.remove(name);
  }
  const auto ledger = out_ / "ledger.csv";
  std::string old;
  for (const auto& row : csv(ledger)) {
    for (std::size_t k = 0; k < 21; ++k) old += (k > 0 ? "," : "") + row[k];
    old += "\n";
  }
  std::ofstream(ledger) << old;
  EXPECT_EQ(bits_of_state(read_state(out_)), bits_of_state(first));
  write({second}, true, 2);
  EXPECT_EQ(expect_data(out_, index()), 23 + 25);
  const auto rows = csv(ledger);
  ASSERT_EQ(rows.size(), 3u);
  for (const auto& row : rows) EXPECT_EQ(row.size(), 28u);
  EXPECT_EQ(rows[1][0], "2");
  EXPECT_EQ(rows[1][27], "nan");
  EXPECT_NE(rows[2][25], "nan");
}

TEST_F(RunOutput, AnEarlierRunIsRemovedOrContinued) {
  const auto run = [&](int from, int to, int resume_after) {
    RunWriter<2> writer(out_, scene_, "", resume_after);
    for (int step = from; step <= to; ++step) {
      const State<2> state = at(step);
      writer.step(state, report_of(state));
      if (step % 2 == 0) writer.frame(state);
    }
    writer.close();
  };
  run(1, 8, -1);
  run(5, 6, 4);
  EXPECT_EQ(steps_in_folder(out_), (std::vector<int>{2, 4, 6}));
  EXPECT_EQ(csv(out_ / "ledger.csv").size(), 1u + 3u);
  EXPECT_EQ(csv(out_ / "trajectory.csv").size(), 1u + 2 * 6u);
  EXPECT_EQ(expect_data(out_, index()), 3 * 25);
  run(1, 2, -1);
  EXPECT_EQ(steps_in_folder(out_), (std::vector<int>{2}));
  EXPECT_EQ(csv(out_ / "ledger.csv").size(), 1u + 1u);
}

TEST_F(ThreadedRunOutput, FramesWrittenBesideTheStepsAreTheSameFiles) {
  for (const bool beside : {false, true}) {
    RunWriter<2> writer(folder_ / (beside ? "beside" : "waited"), scene_, "text");
    writer.frame(at(0));
    for (int step = 1; step < 80; ++step) {
      State<2> state = at(step);
      writer.step(state, report_of(state));
      beside ? writer.frame_beside(state) : writer.frame(state);
      state = State<2>();  // the copy is what is written
    }
    writer.close();
  }
  const auto waited = files_in(folder_ / "waited");
  ASSERT_EQ(waited.size(), 80u + 6u);  // run.h5, run.xdmf, and the tables with their units
  EXPECT_TRUE(files_in(folder_ / "beside") == waited);
}

TEST_F(ThreadedRunOutput, AFrameThatFailsBesideIsReportedByTheNextAndOnce) {
  RunWriter<2> writer(out_, scene_, "");
  writer.frame(at(0));
  fs::rename(out_ / "frames", folder_ / "taken");
  writer.frame_beside(at(1));
  const std::string said = refusal_of<FileError>([&] { writer.frame_beside(at(2)); });
  const std::string expected = refusal_of<FileError>([&] { writer.frame(at(1)); });
  EXPECT_NE(expected, refusal_of([] {}));
  EXPECT_EQ(said, expected);
  writer.frame_beside(at(3));
  EXPECT_THROW(writer.close(), FileError);
  fs::rename(folder_ / "taken", out_ / "frames");
  EXPECT_NO_THROW(writer.close());
  EXPECT_EQ(steps_in_folder(out_), std::vector<int>{0});
}

TEST_F(RunOutput, AKillAtAnyTimeLeavesAllFramesReadable) {
  for (int trial = 0; trial < 24; ++trial) {
    const bool beside = trial % 2 == 1;
    fs::remove_all(out_);
    fs::create_directory(out_);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {  // never leaves this block, never outlives a test that is stopped itself
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      try {
        RunWriter<2> writer(out_, scene_, "");
        for (int step = 0; step < 100000; ++step) {
          beside ? writer.frame_beside(at(step)) : writer.frame(at(step));
        }
      } catch (...) {
      }
      ::_exit(1);
    }
    for (int wait = 0; wait < 20000 && steps_in_folder(out_).size() < 2; ++wait) ::usleep(500);
    ::usleep(777 * static_cast<unsigned>(trial / 2));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the writer ended by itself";
    const std::vector<int> steps = steps_in_folder(out_);
    ASSERT_GE(steps.size(), 2u);
    for (int step : steps) {
      ASSERT_EQ(bits_of_state(read_state(out_, step)), bits_of_state(at(step)));
    }
    EXPECT_EQ(markup_defect(index()), "");
    EXPECT_GT(expect_data(out_, index()), 0);
  }
}

TEST_F(RunOutput, UnusableFoldersAndDamagedFilesAreRefused) {
  std::ofstream(folder_ / "file") << "in the way";
  EXPECT_THROW(RunWriter<2>(folder_ / "file", scene_, ""), FileError);
  Scene<2> other = scene_;
  other.output.track = {3};
  EXPECT_THROW(RunWriter<2>(out_, other, ""), std::invalid_argument);
  RunWriter<2> writer(out_, scene_, "");
  EXPECT_THROW(read_state(out_), FileError);  // no frame yet
  State<2> wrong = at(1);
  wrong.bodies.pop_back();
  EXPECT_THROW(writer.frame(wrong), std::invalid_argument);
  writer.frame(at(5));
  writer.frame(at(5));  // the same again: nothing happens
  EXPECT_THROW(writer.frame(at(4)), std::invalid_argument);
  const auto damaged = [&](const char* name, double value) {
    Hdf5File(out_ / "frames/00000005.h5", Hdf5File::Mode::kAppend).write(name, value);
    return refusal_of<FileError>([&] { read_state(out_); });
  };
  EXPECT_TRUE(says(damaged("/time", kNaN), "/time: step 5, nan s"));
  EXPECT_EQ(damaged("/time", 0.5), "nothing was thrown");
  const auto lost = [&](const auto& spoil) {
    State<2> state = at(5);
    spoil(state.bodies[0]);
    RunWriter<2>(folder_ / "lost", scene_, "").frame(state);
    return refusal_of<FileError>([&] { read_state(folder_ / "lost"); });
  };
  const std::string said = "disk 0: place or motion is not finite";
  EXPECT_TRUE(says(lost([](Disk& d) { d.v[1] = kNaN; }), said));
  EXPECT_TRUE(says(lost([](Disk& d) { d.spin = kInfinity; }), said));
  Hdf5File(out_ / "frames/00000005.h5", Hdf5File::Mode::kAppend)
      .write("/contacts/j", std::vector<int>{1, 6});
  EXPECT_THROW(read_state(out_), FileError);
  Hdf5File(out_ / "frames/00000005.h5", Hdf5File::Mode::kAppend).remove("/bodies/v");
  EXPECT_THROW(read_state(out_), FileError);
  Hdf5File(out_ / "run.h5", Hdf5File::Mode::kAppend).write("/format_version", 99);
  EXPECT_THROW(read_state(out_), FileError);
}

}  // namespace
}  // namespace bipot
