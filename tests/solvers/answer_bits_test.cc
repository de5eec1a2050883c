// Hashes of the impulses that solvers without a factorisation reach on shipped problems: the same
// bits on every machine, with every compiler, and for any number of threads. A change of these
// numbers is a change of answers. It must be wanted.

#include <array>
#include <thread>

#include "solvers/solve.h"
#include "tests/support/bit_hash.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

struct Answer {
  const char* problem;
  std::uint64_t uzawa, pgs, tiled, apgd, assor;
};
constexpr Answer kAnswers[] = {
    {"1d_square_20", 0xa606291710bd25a5, 0x4770f6e5f30bb7f5, 0xa69f2ff9875c33a5, 0x80ef121c194ff08d,
     0xf3e79e625e130f2f},
    {"2d_compaction_flow", 0x8eba991a219491cc, 0x2657a08709db0f3d, 0x8b0af45464b6e003,
     0x632ef5c63b8e1716, 0xe24ddb9c103302a4},
    {"2d_pile_300_mu03", 0xa2a4f552cfbde935, 0x34a4abaa0731764e, 0x68b9303a324e3237,
     0x2d16bf8d75becc96, 0x293df85e528c4846},
    {"2d_pour14_230", 0x7438a10e21b9f7ab, 0x5f789b9780795e7, 0x1fdadd5f979552d2, 0xaef6d3f277989452,
     0xb0564040d8d6bf6c},
    {"2d_pour300_392", 0xa5079b0fe4a1fe45, 0xe418e7b3568243ae, 0x9ccada3833be1180,
     0x3f25aa078d30394, 0x3aeb64b1a97f57a},
    {"2d_pyramid_20_mu05", 0x138bd44fb6cd4483, 0x51455096898c5f65, 0x1633b5a8bd8aa83f,
     0xbb638d4dde3eee85, 0xe61995723458af07},
    {"2d_strike12_450", 0x8c34e0eb1dd59c14, 0x769ea3694b769db7, 0xf0b375d718d45587,
     0x2fa88b83cbf8b2a3, 0xbe5b6685bfdfccff},
    {"2d_tilt1000hi_182", 0x5710da19a28c6401, 0xfa7722d9af470083, 0x7c123cbbbb259ec3,
     0xa624319b2786cec2, 0x28cb088bf9183973},
    {"2d_triangular_20_tilt10", 0x8ffe539d5d56966f, 0xcc3dd42fbdaf5441, 0xd3f3e6b466dc84da,
     0xdf0a92de90fb5b97, 0x9145df0cb3c48016},
    {"3d_sphere_pyramid_4", 0x4fae00fe5ed9980c, 0xe18b88ca93a6e111, 0x1be8e8b8c8e88384,
     0xd1954e607311e42e, 0xef8aa6f138eeba0a},
};

/// As it stands in the table above.
std::string row(const Answer& a) {
  return fmt::format("{{\"{}\", {:#x}, {:#x}, {:#x}, {:#x}, {:#x}}},", a.problem, a.uzawa, a.pgs,
                     a.tiled, a.apgd, a.assor);
}

/// Of 60 iterations, so that every solver has an impulse that no tolerance has stopped.
std::uint64_t bits_of(const std::string& solver, const ContactProblem& p, int threads,
                      const std::map<std::string, std::string>& parameters = {}) {
  SolverOptions options{.tol = 1e-15, .max_iterations = 60};
  options.execution.threads = threads;
  options.parameters = parameters;
  BitHash hash;
  hash.add(solve(solver, p, options).s);
  return hash.value();
}

TEST(AnswerBits, AreThoseOfEveryMachineCompilerAndNumberOfThreads) {
  for (const Answer& known : kAnswers) {
    const ContactProblem p = shipped_file(std::string(known.problem) + ".hdf5");
    for (const int threads : {1, 2}) {
      const Answer found = {known.problem,
                            bits_of("uzawa", p, threads),
                            bits_of("pgs", p, threads),
                            bits_of("pgs", p, threads, {{"order", "tiled"}}),
                            bits_of("apgd", p, threads),
                            bits_of("assor", p, threads)};
      EXPECT_EQ(row(found), row(known)) << threads << " threads";
    }
  }
}

// Dense kernels of factors take turns: OpenBLAS's serial build shares buffers between threads.
TEST(AnswerBits, AreThoseOfOneCallerWhereSeveralSolveAtOnce) {
  for (const char* solver : {"pdas", "ptc", "ipm", "auto"}) {
    SCOPED_TRACE(solver);
    const ContactProblem p = shipped_file("2d_pile_300_mu03.hdf5");
    const std::uint64_t alone = bits_of(solver, p, 1);
    std::array<std::array<std::uint64_t, 4>, 3> found{};
    std::vector<std::thread> callers;
    for (auto& mine : found) {
      callers.emplace_back([&] {
        for (std::uint64_t& bits : mine) bits = bits_of(solver, p, 1);
      });
    }
    for (std::thread& caller : callers) caller.join();
    for (const auto& of_caller : found) {
      for (const std::uint64_t bits : of_caller) EXPECT_EQ(bits, alone);
    }
  }
}

}  // namespace
}  // namespace bipot
