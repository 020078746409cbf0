# %% [markdown]
# **1.** The impact takes the energy of $\sqrt3/6$ of an element's mass. What share of the energy is
# that with 20 elements? Calculate it, then test it by `throw`. (Take a number of elements that is
# divisible by five: then a step ends where the bar arrives.) Reach **-0.0144**.

# %%
few = throw(ThetaScheme(0.5), cells=20)
answer = few["impact"][-1] / few["kinetic"][0]

# %% [markdown]
# **2.** How much energy is left with $\theta = 0.75$ and the forces at the $\theta$-point? Compare
# with the printed scheme at $\theta = 1/2$: why are they the same? Reach **0.877**.

# %%
run = throw(ThetaScheme(0.75))
answer = (run["kinetic"][-1] + run["strain"][-1]) / run["kinetic"][0]

# %% [markdown]
# **3.** Whatever the energy, momentum is kept: the impulse of the wall is the change of momentum of
# the bar. By how much do they differ in the printed scheme, $\theta = 1$? Reach **0.000000** N s.

# %%
printed = runs["θ = 1, as printed"]
mass = bar.density * bar.length
answer = printed.impulse("wall")[-1, 0] - mass * (printed["v"][-1] - printed["v"][0])

# %% [markdown]
# **4.** The law of positions in the same scene ($\theta = 1/2$): how much energy is left? It
# bounces back, as in lesson 1, and loses less; look at its force for the price. Reach **0.999**.

# %%
run = throw(ThetaScheme(0.5), law="gap")
answer = (run["kinetic"][-1] + run["strain"][-1]) / run["kinetic"][0]
