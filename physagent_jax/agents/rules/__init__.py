"""The offline agents: rules, no model, no network."""
