/* memory.h: what runs, factors and condensed bodies take of memory, and what there is (memory.c). */
#pragma once
#include "base/base.h"
#include <petscmat.h>

/* [byte] What this process may still take, by the machine, the limits of the process and of its group. */
double MemoryAvailable(void);
/* [byte] What a rank will take of an explicit run. */
double MemoryOfRank(PetscInt n_vertices, PetscInt n_blocks, double n_contacts, PetscMPIInt size,
                    PetscMPIInt rank);
/* [byte] What the `local` ranks of this machine, the first among them, will take of a run on `size` ranks. */
double MemoryNeeded(PetscInt n_vertices, PetscInt n_blocks, PetscMPIInt size, PetscMPIInt local);
/* [byte] All ranks of a machine shall take no more than this together; 0: what is free there. */
void MemorySetLimit(double bytes);
/* Collective. Whether `mine` [byte] more on this rank, for a factor, and what the others ask for, fits on
   every machine. sum: [0] asked for by all ranks, [1] available on all machines [byte]; 0 on a machine where
   BLAS has no room to work. */
PetscErrorCode MemoryFits(MPI_Comm comm, double mine, double sum[2], PetscBool *fits);
/* [byte] On all ranks together: Newton's method with n_dof degrees of freedom and n_dense entries in the
   dense blocks of condensed bodies, over what an explicit run keeps. */
double MemoryOfFactor(double n_dof, double n_dense, PetscMPIInt size);
/* Whether MUMPS gave up a factor, symbolic or numeric, for want of memory. Collective where the factor is. */
PetscErrorCode MumpsWants(Mat factor, PetscBool *wants);
/* [byte] The factor of a condensed body, and what is left of it. */
double MemoryOfBody(double n_inner, double n_kept);
/* [byte] What a rank will take of a run by Newton's method, whose factor takes `factor` on all ranks. */
double MemoryOfNewton(PetscInt n_vertices, PetscInt n_blocks, double n_contacts, double factor,
                      PetscMPIInt size, PetscMPIInt rank);
/* From now on memory that is freed goes back to the system. Once, after MPI has started. */
void MemoryReturnFreed(void);
