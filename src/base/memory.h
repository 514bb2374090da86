/* memory.h: declares estimates of the memory of runs, factors and condensed bodies, and the memory
   available (memory.c). */
#pragma once
#include "base/base.h"
#include <petscmat.h>

/* Returns the memory [byte] that this process may still take, by the machine and by the limits of process
   and group. */
double MemoryAvailable(void);
/* Returns the memory [byte] of a rank in an explicit run. */
double MemoryOfRank(PetscInt n_vertices, PetscInt n_blocks, double n_contacts, PetscMPIInt size,
                    PetscMPIInt rank);
/* Returns the additional memory [byte] of a rank in an explicit run in which joints or blocks can fail. */
double MemoryOfFailing(PetscInt n_vertices, PetscMPIInt size, PetscMPIInt rank);
/* Returns the memory [byte] of the `local` ranks of this machine, which are the first ones, in a run on
   `size` ranks. */
double MemoryNeeded(PetscInt n_vertices, PetscInt n_blocks, PetscMPIInt size, PetscMPIInt local);
/* Limits the memory [byte] of all ranks of a machine together; 0: to the memory that is free there. */
void MemorySetLimit(double bytes);
/* Collective. Decides whether every machine has room for a factor that takes `mine` [byte] more on this
   rank, and the requests of the other ranks. sum: [0] requested by all ranks, [1] available on all
   machines [byte], 0 on a machine where BLAS has no room to work. */
PetscErrorCode MemoryFits(MPI_Comm comm, double mine, double sum[2], PetscBool *fits);
/* Returns the memory [byte] of Newton's method on all ranks together, beyond the memory of an explicit run:
   n_dof degrees of freedom, n_dense entries in the dense blocks of condensed bodies. */
double MemoryOfFactor(double n_dof, double n_dense, PetscMPIInt size);
/* Collective on the ranks of the factor. Decides whether MUMPS gave up a factor (symbolic or numeric) for
   lack of memory. */
PetscErrorCode MumpsWants(Mat factor, PetscBool *wants);
/* Returns the memory [byte] of a condensed body: its factor and its reduced matrix. */
double MemoryOfBody(double n_inner, double n_kept);
/* Returns the memory [byte] of a rank in a run by Newton's method; `factor`: [byte] of the factor on all
   ranks. */
double MemoryOfNewton(PetscInt n_vertices, PetscInt n_blocks, double n_contacts, double factor,
                      PetscMPIInt size, PetscMPIInt rank);
/* Makes freed memory go back to the system from now on. Call once, after MPI has started. */
void MemoryReturnFreed(void);
