// The texts of the log of a run in stages. All calls are collective; rank 0 prints.
#pragma once

#include <memory>
#include <string>

#include "model/scene/world.hpp"
#include "model/scheme/waiting.hpp"
#include "trackbed/model/run_context.hpp"
#include "trackbed/model/scheme.hpp"

namespace trackbed::model {

// The main properties of the model, to check that it is the intended one.
void say_model(World& world, const std::string& name);
void say_stage_begins(RunContext& run, World& world, const Stage& stage);
void say_stage_ends(const par::Comm& comm, const StageRecord& record);
// Static equilibrium of the ground: a line now, and one every 5 s until the returned object is
// destroyed.
std::unique_ptr<Waiting> say_equilibrium(const World& world);
// Of a line of progress.
Status status_of(const World& world);

}  // namespace trackbed::model
