/* memory.h: the memory that runs, factors and condensed bodies take, and the memory there is (memory.c). */
#pragma once
#include "base/base.h"
#include <petscmat.h>

/* [byte] What this process may still take, by the machine, its own limits and those of its group. */
double MemoryAvailable(void);
/* [byte] What a rank takes for an explicit run. */
double MemoryOfRank(PetscInt n_vertices, PetscInt n_blocks, double n_contacts, PetscMPIInt size,
                    PetscMPIInt rank);
/* [byte] What a rank takes besides, for an explicit run of a scene in which joints or blocks can fail. */
double MemoryOfFailing(PetscInt n_vertices, PetscMPIInt size, PetscMPIInt rank);
/* [byte] What the `local` ranks of this machine, the first among them, take for a run on `size` ranks. */
double MemoryNeeded(PetscInt n_vertices, PetscInt n_blocks, PetscMPIInt size, PetscMPIInt local);
/* [byte] Limits what all ranks of a machine take together; 0: to what is free there. */
void MemorySetLimit(double bytes);
/* Collective. Whether every machine has room for a factor that takes `mine` [byte] more on this rank, and
   what the other ranks ask for. sum: [0] asked for by all ranks, [1] available on all machines [byte], 0 on a
   machine where BLAS has no room to work. */
PetscErrorCode MemoryFits(MPI_Comm comm, double mine, double sum[2], PetscBool *fits);
/* [byte] What Newton's method takes on all ranks together, beyond what an explicit run keeps: n_dof degrees
   of freedom, n_dense entries in the dense blocks of condensed bodies. */
double MemoryOfFactor(double n_dof, double n_dense, PetscMPIInt size);
/* Collective where the factor is. Whether MUMPS gave up a factor (symbolic or numeric) for lack of memory. */
PetscErrorCode MumpsWants(Mat factor, PetscBool *wants);
/* [byte] What a condensed body takes: its factor and its reduced matrix. */
double MemoryOfBody(double n_inner, double n_kept);
/* [byte] What a rank takes for a run by Newton's method; `factor`: [byte] of the factor on all ranks. */
double MemoryOfNewton(PetscInt n_vertices, PetscInt n_blocks, double n_contacts, double factor,
                      PetscMPIInt size, PetscMPIInt rank);
/* From now on freed memory goes back to the system. Call once, after MPI has started. */
void MemoryReturnFreed(void);
