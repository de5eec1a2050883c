#include "core/run_files/background_writer.h"

#include <pthread.h>

#include <atomic>
#include <csignal>
#include <future>
#include <thread>

#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(ThreadedWriter, TheCallerGoesOnWhileAJobIsUnderWay) {
  std::promise<void> release;
  std::atomic<bool> done = false;
  BackgroundWriter writer;
  writer.begin([&] {
    release.get_future().wait();
    done = true;
  });
  EXPECT_FALSE(done);
  release.set_value();  // never reached where begin() does the job itself
  writer.finish();
  EXPECT_TRUE(done);
}

TEST(ThreadedWriter, JobsAreDoneOneAtATimeInTheirOrder) {
  std::vector<int> order;
  std::atomic<int> under_way = 0;
  bool alone = true;
  {
    BackgroundWriter writer;
    for (int k = 0; k < 1000; ++k) {
      writer.begin([&, k] {
        alone = alone && ++under_way == 1;
        order.push_back(k);
        --under_way;
      });
    }
  }  // waits for the last
  EXPECT_TRUE(alone);
  ASSERT_EQ(order.size(), 1000u);
  for (int k = 0; k < 1000; ++k) EXPECT_EQ(order[static_cast<std::size_t>(k)], k);
}

TEST(ThreadedWriter, WhatAJobThrowsIsThrownOnceByTheNextCall) {
  BackgroundWriter writer;
  const auto fail = [] { throw std::runtime_error("full"); };
  bool begun = false;
  writer.begin(fail);
  EXPECT_THROW(writer.begin([&] { begun = true; }), std::runtime_error);
  EXPECT_FALSE(begun);
  EXPECT_NO_THROW(writer.finish());
  writer.begin(fail);
  EXPECT_THROW(writer.finish(), std::runtime_error);
  writer.begin([&] { begun = true; });
  writer.finish();
  EXPECT_TRUE(begun);
  writer.begin(fail);  // nobody asks: lost, and the writer ends
}

TEST(ThreadedWriter, ACheckDoesNotWait) {
  std::promise<void> release;
  BackgroundWriter writer;
  writer.begin([&] {
    release.get_future().wait();
    throw std::runtime_error("full");
  });
  EXPECT_NO_THROW(writer.check());
  release.set_value();
  const auto fails_within_seconds = [&] {
    for (int wait = 0; wait < 10000; ++wait) {
      try {
        writer.check();
      } catch (const std::runtime_error&) {
        return true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  };
  EXPECT_TRUE(fails_within_seconds());
  EXPECT_NO_THROW(writer.finish());
}

TEST(ThreadedWriter, SignalsThatEndARunGoToTheCaller) {
  bool blocked = false;
  BackgroundWriter writer;
  writer.begin([&] {
    sigset_t mask;
    pthread_sigmask(SIG_BLOCK, nullptr, &mask);
    blocked = sigismember(&mask, SIGINT) == 1 && sigismember(&mask, SIGTERM) == 1;
  });
  writer.finish();
  EXPECT_TRUE(blocked);
  sigset_t mask;
  pthread_sigmask(SIG_BLOCK, nullptr, &mask);
  EXPECT_EQ(sigismember(&mask, SIGTERM), 0);
}

}  // namespace
}  // namespace bipot
