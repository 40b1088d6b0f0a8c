// Ownership of PETSc objects.
#pragma once

#include <petscksp.h>

namespace trackbed::fem {

// Owns one PETSc object, or none, and destroys it; converts to the handle that PETSc's functions
// take. Objects that live longer than PETSc (static destruction after PetscFinalize) are left to
// the end of the program: destroying them then is an error in PETSc.
template <class T, PetscErrorCode (*destroy)(T*)>
class PetscOwned {
 public:
  PetscOwned() = default;
  ~PetscOwned() {
    PetscBool running = PETSC_FALSE;
    PetscInitialized(&running);
    if (running == PETSC_TRUE) destroy(&object_);  // accepts none
  }
  PetscOwned(const PetscOwned&) = delete;
  PetscOwned& operator=(const PetscOwned&) = delete;

  operator T() const { return object_; }
  // For the function that creates the object; only while there is none.
  T* create() { return &object_; }

 private:
  T object_ = nullptr;
};

using OwnedMat = PetscOwned<Mat, MatDestroy>;
using OwnedVec = PetscOwned<Vec, VecDestroy>;
using OwnedKSP = PetscOwned<KSP, KSPDestroy>;
using OwnedNullSpace = PetscOwned<MatNullSpace, MatNullSpaceDestroy>;

}  // namespace trackbed::fem
